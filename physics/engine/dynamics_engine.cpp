#include "touchstone/physics/engine/dynamics_engine.hpp"

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
  for (const Vector3& v : {force_W, p_W, moment_W})
    if (!touchstone::is_finite(v)) refuse("a figure that is not finite");
  take_push(object, force_W, p_W, moment_W);
}

}  // namespace touchstone::physics
