#include "touchstone/physics/engine/dynamics_engine.hpp"

#include <array>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics {

void DynamicsEngine::push(std::size_t object, const Vector3& force_W, const Vector3& p_W,
                          const Vector3& moment_W) {
  if (object >= scene().bodies.size()) throw InputError("push: no such object");
  const auto refuse = [&](const char* why) {  // makes its text only then: a push does not allocate
    throw InputError("push: object '" + scene().scene.objects[object].tree.name() + "': " + why);
  };
  const BodyKind kind = scene().bodies[object].kind;
  if (kind == BodyKind::fixed) refuse("is fixed: no force moves it");
  if (kind == BodyKind::kinematic) refuse("follows its motion: no force moves it");
  if (!has(object)) refuse("is not in the world");
  for (const Vector3& v : {force_W, p_W, moment_W})
    if (!touchstone::is_finite(v)) refuse("a figure that is not finite");
  take_push(object, force_W, p_W, moment_W);
}

std::string_view to_string(EngineReturn after) {
  constexpr std::array<std::string_view, 3> kNames{"-", "repeatable", "same bits"};
  return kNames[static_cast<std::size_t>(after)];
}

namespace {

/// @throws InputError unless the object is a free one of its own that is in, or out.
void require_free(const DynamicsEngine& engine, std::size_t object, bool is_in, const std::string& call) {
  const DynamicScene& scene = engine.scene();
  if (object >= scene.bodies.size()) throw InputError(call + ": no such object");
  const auto refuse = [&](const std::string& why) {
    throw InputError(call + ": object '" + scene.scene.objects[object].tree.name() + "': " + why);
  };
  if (scene.bodies[object].kind != BodyKind::dynamic) refuse("is not dynamic");
  if (engine.has(object) != is_in) refuse(is_in ? "is not there" : "is there already");
  if (const std::string joint = joint_that_holds(scene, object); !joint.empty())
    refuse("is held by joint '" + joint + "'");
}

}  // namespace

void DynamicsEngine::remove(std::size_t object) {
  require_free(*this, object, true, "remove");
  take_out(object);
}

void DynamicsEngine::add(std::size_t object, const Pose& X_WO, const Vector3& v_W, const Vector3& w_W) {
  require_free(*this, object, false, "add");
  const std::string who = "add: object '" + scene().scene.objects[object].tree.name() + "': ";
  if (!is_valid_pose(X_WO)) throw InputError(who + "a bad pose");
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(who + "velocities that are not finite");
  put_in(object, X_WO, v_W, w_W);
}

void DynamicsEngine::act(const SceneAction& action) {
  ScenePlaces now;
  for (std::size_t i = 0; i < scene().bodies.size(); ++i) {
    now.carriers.push_back(carrier_of(i));
    now.is_out.push_back(has(i) ? 0 : 1);
  }
  validate_action(scene(), action, now);
  const std::vector<std::string> lacking = unsupported(features_, scene(), action);
  if (!lacking.empty()) throw InputError("act: unsupported: " + joined(lacking));
  take_action(action);
}

}  // namespace touchstone::physics
