#include "touchstone/physics/scene/dynamic_scene.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"

namespace touchstone::physics {
namespace {

[[noreturn]] void reject(const std::string& where, const std::string& reason) {
  throw InputError(where + reason);
}

bool is_number_at_least_0(double value) { return value >= 0.0; }  // infinity too, not NaN

void validate_drive(const SceneDrive& drive, const std::string& name) {
  if (!is_number_at_least_0(drive.drive.limit)) reject(name, "a torque limit below 0");
  if (!std::isfinite(drive.drive.torque) || !std::isfinite(drive.drive.rate) || !std::isfinite(drive.ramp))
    reject(name, "torque, ramp or rate is not finite");
  if (!std::isfinite(drive.drive.position)) reject(name, "the position is not finite");
  for (const double figure : {drive.drive.stiffness, drive.drive.damping})
    if (!is_number_at_least_0(figure) || std::isinf(figure))
      reject(name, "stiffness and damping must be >= 0");
  if (drive.ramp != 0.0 && drive.drive.mode != JointDrive::Mode::torque)
    reject(name, "only a torque has a ramp");
}

void validate_losses(const JointLosses& losses, const std::string& name) {
  for (const double figure : {losses.friction, losses.damping})
    if (!is_number_at_least_0(figure) || std::isinf(figure))
      reject(name, "friction and damping must be >= 0");
}

bool is_driven(const SceneDrive& drive) {
  return drive.drive.mode != JointDrive::Mode::torque || drive.drive.torque != 0.0 || drive.ramp != 0.0;
}

/// @return the joint of a mechanism. @throws InputError where there is none, or none that moves.
const SceneJoint& require_joint(const DynamicScene& scene, const JointAddress& joint,
                                const std::string& where) {
  if (joint.mechanism >= scene.mechanisms.size())
    reject(where, "no mechanism " + std::to_string(joint.mechanism));
  const SceneMechanism& mechanism = scene.mechanisms[joint.mechanism];
  if (joint.joint >= mechanism.joints.size())
    reject(where, "mechanism '" + mechanism.name + "' has no joint " + std::to_string(joint.joint));
  const SceneJoint& found = mechanism.joints[joint.joint];
  if (found.kind == JointKind::fixed)
    reject(where, "mechanism '" + mechanism.name + "': joint '" + found.name + "' is fixed");
  return found;
}

/// @throws InputError where there is none, or none that moves.
void require_moving(const DynamicScene& scene, const JointAddress& joint, const std::string& where) {
  if (!joint.is_of_bodies()) {
    require_joint(scene, joint, where);
    return;
  }
  if (joint.joint >= scene.joints.size()) reject(where, "no joint " + std::to_string(joint.joint));
  const SceneBodyJoint& found = scene.joints[joint.joint];
  if (found.kind != BodyJointKind::hinge && found.kind != BodyJointKind::slider)
    reject(where, "joint '" + found.name + "' has no axis");
}

bool is_ground(const DynamicScene& scene, std::size_t object) {
  return object == kNoObject || scene.bodies[object].kind == BodyKind::fixed;
}

void validate_mechanism(const DynamicScene& scene, const SceneMechanism& mechanism,
                        std::vector<std::string>& moved_by) {
  const std::string name = mechanism.where + "mechanism '" + mechanism.name + "': ";
  if (mechanism.name.empty()) reject(mechanism.where, "a mechanism without a name");
  if (mechanism.joints.empty()) reject(name, "no joint");
  for (const SceneJoint& joint : mechanism.joints) validate_joint(scene, mechanism, joint);
  for (const SceneJoint& joint : mechanism.joints) {
    const std::string here = joint.where + "mechanism '" + mechanism.name + "': joint '" + joint.name + "': ";
    std::string& other = moved_by[joint.child];
    if (!other.empty())
      reject(here, object_name(scene, joint.child) + " is already moved by joint '" + other + "'");
    other = joint.name;
    const auto is_parent = [&](const SceneJoint& each) { return each.child == joint.parent; };
    if (!is_ground(scene, joint.parent) &&
        std::none_of(mechanism.joints.begin(), mechanism.joints.end(), is_parent))
      reject(here, object_name(scene, joint.parent) + " is neither fixed nor a link of this mechanism");
  }
  for (std::size_t i = 0; i < mechanism.joints.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (mechanism.joints[i].name == mechanism.joints[k].name)
        reject(mechanism.joints[i].where,
               "mechanism '" + mechanism.name + "': joint '" + mechanism.joints[i].name + "' occurs twice");
}

/// Follows which object carries which through latches and releases, as they will be carried out.
class LatchPlan {
 public:
  explicit LatchPlan(const DynamicScene& scene)
      : LatchPlan(scene, {std::vector(scene.scene.objects.size(), kNoObject), absent_at_start(scene)}) {}
  LatchPlan(const DynamicScene& scene, ScenePlaces now)
      : scene_(&scene), carrier_(std::move(now.carriers)), is_out_(std::move(now.is_out)) {}

  void latch(std::size_t carrier, std::size_t carried, const std::string& where) {
    const std::string here = where + "latch: ";
    if (carrier >= carrier_.size() || carried >= carrier_.size()) reject(here, "no such object");
    if (scene_->bodies[carried].kind != BodyKind::dynamic)
      reject(here, object_name(*scene_, carried) + " is " +
                       std::string(to_string(scene_->bodies[carried].kind)) +
                       ": only dynamic ones are carried");
    if (carrier_[carried] != kNoObject)
      reject(here, object_name(*scene_, carried) + " is already carried by " +
                       object_name(*scene_, carrier_[carried]));
    for (std::size_t i = carrier; i != kNoObject; i = carrier_[i])
      if (i == carried) reject(here, "closes a cycle");
    for (const std::size_t object : {carrier, carried})
      if (is_out_[object] != 0) reject(here, object_name(*scene_, object) + " is not in the world then");
    carrier_[carried] = carrier;
  }
  void release(std::size_t carried, const std::string& where) {
    if (carried >= carrier_.size()) reject(where, "release: no such object");
    if (carrier_[carried] == kNoObject)
      reject(where, "release: " + object_name(*scene_, carried) + " is not carried");
    carrier_[carried] = kNoObject;
  }
  void come_or_go(std::size_t object, bool comes, const std::string& where) {
    const std::string here = where + (comes ? "add: " : "remove: ");
    if (object >= carrier_.size()) reject(here, "no such object");
    const std::string name = object_name(*scene_, object);
    if (scene_->bodies[object].kind != BodyKind::dynamic)
      reject(here, name + " is " + std::string(to_string(scene_->bodies[object].kind)) +
                       ": only dynamic ones come and go");
    if (const std::string joint = joint_that_holds(*scene_, object); !joint.empty())
      reject(here, name + " is held by joint '" + joint + "'");
    if ((is_out_[object] != 0) != comes) reject(here, name + (comes ? " is there already" : " is not there"));
    if (carrier_[object] != kNoObject)
      reject(here, name + " is carried by " + object_name(*scene_, carrier_[object]));
    if (std::find(carrier_.begin(), carrier_.end(), object) != carrier_.end())
      reject(here, name + " carries another object");
    is_out_[object] = comes ? 0 : 1;
  }

 private:
  const DynamicScene* scene_;
  std::vector<std::size_t> carrier_;
  std::vector<std::uint8_t> is_out_;
};

void validate_allowed(const DynamicScene& scene, std::span<const ExemptPair> allowed,
                      const std::string& where) {
  try {
    for (const ExemptPair& pair : allowed)
      for (const std::string* name : {&pair.first, &pair.second}) find_solids(scene.scene, *name);
  } catch (const InputError& error) {
    throw InputError(where + "latch: " + error.what());
  }
}

void validate_latch_options(const DynamicScene& scene) {
  for (const SceneLatchOption& option : scene.latch_options) {
    LatchPlan(scene).latch(option.carrier, option.carried, "");
    validate_allowed(scene, option.allowed, "");
  }
}

void validate_joint_action(const DynamicScene& scene, const SceneAction& action) {
  using Kind = SceneAction::Kind;
  if (action.kind == Kind::drive) {
    require_moving(scene, action.joint, action.where + "drive: ");
    validate_drive(action.drive, action.where + "drive: ");
  }
  // Joints are put within their limits.
  if (action.kind == Kind::set_joint) {
    if (action.joint.is_of_bodies()) reject(action.where, "set: only joints of mechanisms are put at values");
    const SceneJoint& joint = require_joint(scene, action.joint, action.where + "set: ");
    if (!std::isfinite(action.rate) || !(action.value >= joint.lower && action.value <= joint.upper))
      reject(action.where, "set: joint '" + joint.name + "': the value is out of its limits, or no number");
  }
  if (action.kind == Kind::join || action.kind == Kind::part) {
    const bool is_known = action.joint.is_of_bodies() && action.joint.joint < scene.joints.size();
    if (!is_known) reject(action.where, "join or part: no joint between bodies");
  }
}

/// The plan goes on with what the action does.
void validate_in_plan(const DynamicScene& scene, const SceneAction& action, LatchPlan& plan) {
  using Kind = SceneAction::Kind;
  if (action.kind == Kind::latch) {
    plan.latch(action.carrier, action.carried, action.where);
    validate_allowed(scene, action.allowed, action.where);
  }
  if (action.kind == Kind::release) plan.release(action.carried, action.where);
  if (action.kind == Kind::add || action.kind == Kind::remove)
    plan.come_or_go(action.carried, action.kind == Kind::add, action.where);
  validate_joint_action(scene, action);
}

void validate_actions(const DynamicScene& scene) {
  // The plan starts with the latches that hold from the start.
  LatchPlan plan(scene);
  for (const SceneLatch& latch : scene.scene.latches)
    plan.latch(find_object(scene.scene, latch.carrier), find_object(scene.scene, latch.carried), "");
  // Actions must be in order of time, and each is checked by its kind.
  double earliest = 0.0;
  for (const SceneAction& action : scene.actions) {
    if (!(action.time >= earliest) || !std::isfinite(action.time))
      reject(action.where, "action: the time is before the action above, or is none");
    earliest = action.time;
    validate_in_plan(scene, action, plan);
  }
}

void validate_answer(const DynamicScene& scene, const SceneAnswer& answer) {
  using Figure = SceneAnswer::Figure;
  const std::string here = answer.where + "answer '" + std::string(to_string(answer.figure)) + "': ";
  if (answer.is_of_joint()) require_moving(scene, answer.joint, here);
  if (answer.is_vector() && answer.object >= scene.bodies.size()) reject(here, "no such object");
  if ((answer.figure == Figure::velocity || answer.figure == Figure::angular_velocity) &&
      scene.bodies[answer.object].kind != BodyKind::dynamic)
    reject(here, object_name(scene, answer.object) + " is not dynamic: it has no such figure");
  if (!touchstone::is_finite(answer.value)) reject(here, "the value is not finite");
  if (!(answer.tolerance > 0.0) || !std::isfinite(answer.tolerance))
    reject(here, "the tolerance is not above 0");
  // Looked at after the nearest step.
  const double step = std::round(answer.time / scene.step);
  if (!(step >= 1.0 && step <= static_cast<double>(scene.step_count())))
    reject(here, "the time is not that of a step's end");
}

/// Objects that latches ever carry.
std::vector<std::uint8_t> carried_objects(const DynamicScene& scene) {
  std::vector<std::uint8_t> carried(scene.bodies.size(), 0);
  for (const SceneLatch& latch : scene.scene.latches) carried[find_object(scene.scene, latch.carried)] = 1;
  for (const SceneAction& action : scene.actions)
    if (action.kind == SceneAction::Kind::latch && action.carried < carried.size())
      carried[action.carried] = 1;
  for (const SceneLatchOption& option : scene.latch_options)
    if (option.carried < carried.size()) carried[option.carried] = 1;
  return carried;
}

void validate_body_joint(const DynamicScene& scene, const SceneBodyJoint& joint) {
  if (joint.name.empty()) reject(joint.where, "a joint without a name");
  const std::string name = joint.where + "joint '" + joint.name + "': ";
  if (joint.child >= scene.bodies.size()) reject(name, "no such child");
  if (joint.parent != kNoObject && joint.parent >= scene.bodies.size()) reject(name, "no such parent");
  if (joint.parent == joint.child) reject(name, "parent and child are one object");
  const auto moves = [&](std::size_t object) {
    return object != kNoObject &&
           (scene.bodies[object].kind == BodyKind::dynamic || scene.bodies[object].kind == BodyKind::link);
  };
  if (!moves(joint.parent) && !moves(joint.child)) reject(name, "neither of the two is dynamic or a link");
  if (!touchstone::is_finite(joint.p_W) || !touchstone::is_finite(joint.axis_W) ||
      !(std::abs(norm(joint.axis_W) - 1.0) <= 1e-9))
    reject(name, "position or axis is not finite, or the axis is not unit");
  if (!(joint.lower <= joint.upper)) reject(name, "the limits are crossed or not numbers");
  if (!is_number_at_least_0(joint.effort)) reject(name, "a torque limit below 0");
  validate_drive(joint.drive, name);
  validate_losses(joint.losses, name);
  const bool has_axis = joint.kind == BodyJointKind::hinge || joint.kind == BodyJointKind::slider;
  const bool asks = is_driven(joint.drive) || std::isfinite(joint.lower) || std::isfinite(joint.upper) ||
                    joint.losses.friction > 0.0 || joint.losses.damping > 0.0;
  if (asks && !has_axis) reject(name, "limits, drives and losses are of joints with an axis alone");
}

void validate_body_joints(const DynamicScene& scene) {
  if (scene.joints.empty()) return;
  const std::vector<std::uint8_t> carried = carried_objects(scene);
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const SceneBodyJoint& joint = scene.joints[i];
    validate_body_joint(scene, joint);
    for (std::size_t k = 0; k < i; ++k)
      if (scene.joints[k].name == joint.name) reject(joint.where, "joint '" + joint.name + "' occurs twice");
    for (const std::size_t object : {joint.parent, joint.child})
      if (object != kNoObject && carried[object] != 0)
        reject(joint.where, "joint '" + joint.name + "': " + object_name(scene, object) +
                                " is carried by a latch: join it to its carrier instead");
  }
}

void validate_pairs(const DynamicScene& scene) {
  for (const ScenePair& pair : scene.pairs) {
    const std::string here = pair.where + "pair: ";
    if (pair.a >= scene.bodies.size() || pair.b >= scene.bodies.size()) reject(here, "no such object");
    if (pair.a == pair.b) reject(here, object_name(scene, pair.a) + " is no pair with itself");
    if (pair.friction && !(is_number_at_least_0(*pair.friction) && std::isfinite(*pair.friction)))
      reject(here, "friction must be >= 0");
    if (pair.restitution && !(is_number_at_least_0(*pair.restitution) && *pair.restitution <= 1.0))
      reject(here, "restitution must be from 0 to 1");
  }
}

void validate_accept(const DynamicScene& scene, const std::string& name) {
  const SceneAccept& accept = scene.accept;
  for (const double limit :
       {accept.depth, accept.position, accept.angle, accept.energy_made, accept.drift, accept.rest})
    if (!is_number_at_least_0(limit)) reject(name, "accept: a limit below 0");
}

void validate_links(const DynamicScene& scene, const std::vector<std::string>& moved_by) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const bool is_link = scene.bodies[i].kind == BodyKind::link;
    if (is_link && moved_by[i].empty())
      reject(scene.bodies[i].where, object_name(scene, i) + " is a link that no joint moves");
    if (!is_link && !moved_by[i].empty())
      reject(scene.bodies[i].where, object_name(scene, i) + " is moved by joint '" + moved_by[i] +
                                        "', but is " + std::string(to_string(scene.bodies[i].kind)));
  }
}

}  // namespace

void validate_action(const DynamicScene& scene, const SceneAction& action, const ScenePlaces& now) {
  LatchPlan plan(scene, now);
  validate_in_plan(scene, action, plan);
  if (action.kind != SceneAction::Kind::latch) return;
  if (const std::string joint = joint_that_holds(scene, action.carried); !joint.empty())
    reject(action.where,
           "latch: " + object_name(scene, action.carried) + " is held by joint '" + joint + "'");
}

std::string_view to_string(BodyKind kind) {
  constexpr std::array<std::string_view, 4> kNames{"static", "kinematic", "dynamic", "link"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view to_string(SceneAnswer::Figure figure) {
  constexpr std::array<std::string_view, 10> kNames{
      "position", "velocity", "angular_velocity", "force", "impact",
      "value",    "rate",     "torque",           "moved", "stopped"};
  return kNames[static_cast<std::size_t>(figure)];
}

std::string unit_of(const SceneAnswer& answer, JointKind kind) {
  using Figure = SceneAnswer::Figure;
  const bool turns = kind == JointKind::revolute;
  switch (answer.figure) {
    // Of bodies.
    case Figure::position:
      return "m";
    case Figure::velocity:
      return "m/s";
    case Figure::angular_velocity:
      return "rad/s";
    case Figure::force:
      return "N";
    case Figure::impact:
      return "N s";
    // Of joints: of an angle or of a length.
    case Figure::value:
      return turns ? "rad" : "m";
    case Figure::rate:
      return turns ? "rad/s" : "m/s";
    case Figure::torque:
      return turns ? "N m" : "N";
    // Times.
    case Figure::moved:
    case Figure::stopped:
      return "s";
  }
  return "";
}

std::vector<std::uint8_t> absent_at_start(const DynamicScene& scene) {
  std::vector<std::uint8_t> is_out(scene.scene.objects.size(), 0), is_known = is_out;
  for (const SceneAction& action : scene.actions) {
    const bool comes = action.kind == SceneAction::Kind::add;
    if ((!comes && action.kind != SceneAction::Kind::remove) || action.carried >= is_out.size()) continue;
    if (is_known[action.carried] == 0) is_out[action.carried] = comes ? 1 : 0;
    is_known[action.carried] = 1;
  }
  return is_out;
}

std::string joint_that_holds(const DynamicScene& scene, std::size_t object) {
  for (const SceneBodyJoint& joint : scene.joints)
    if (joint.parent == object || joint.child == object) return joint.name;
  return "";
}

std::uint64_t DynamicScene::step_count() const {
  return static_cast<std::uint64_t>(std::round(scene.duration / step));
}

JointKind kind_of(const DynamicScene& scene, const JointAddress& joint) {
  if (!joint.is_of_bodies()) return scene.mechanisms[joint.mechanism].joints[joint.joint].kind;
  const BodyJointKind kind = scene.joints[joint.joint].kind;
  if (kind == BodyJointKind::hinge) return JointKind::revolute;
  return kind == BodyJointKind::slider ? JointKind::prismatic : JointKind::fixed;
}

std::string object_name(const DynamicScene& scene, std::size_t object) {
  return "object '" + scene.scene.objects[object].tree.name() + "'";
}

std::string name_of(const DynamicScene& scene, const JointAddress& joint) {
  if (joint.is_of_bodies()) return scene.joints[joint.joint].name;
  const SceneMechanism& mechanism = scene.mechanisms[joint.mechanism];
  return mechanism.name + "." + mechanism.joints[joint.joint].name;
}

SurfacePairs surface_pairs(const DynamicScene& scene) {
  SurfacePairs out;
  out.friction_rule = scene.friction_rule;
  out.restitution_rule = scene.restitution_rule;
  for (const ScenePair& pair : scene.pairs)
    out.set(static_cast<std::uint32_t>(pair.a), static_cast<std::uint32_t>(pair.b),
            {pair.friction, pair.restitution});
  return out;
}

void validate_body(const DynamicScene& scene, std::size_t object) {
  const SceneBody& body = scene.bodies[object];
  const std::string name = body.where + object_name(scene, object);
  if (body.kind == BodyKind::dynamic) validate(body.inertia, Thinness::solid, name);
  if (body.kind == BodyKind::link) validate(body.inertia, Thinness::thin, name);
  if (!scene.scene.objects[object].motion.at_rest() && body.kind != BodyKind::kinematic)
    reject(name, ": has a motion, but is " + std::string(to_string(body.kind)));
  if (!touchstone::is_finite(body.v_W) || !touchstone::is_finite(body.w_W))
    reject(name, ": velocities are not finite");
  if (!is_number_at_least_0(body.surface.friction) || std::isinf(body.surface.friction))
    reject(name, ": friction must be >= 0");
  if (!is_number_at_least_0(body.surface.restitution) || body.surface.restitution > 1.0)
    reject(name, ": restitution must be from 0 to 1");
}

void validate_joint(const DynamicScene& scene, const SceneMechanism& mechanism, const SceneJoint& joint) {
  const std::string name = joint.where + "mechanism '" + mechanism.name + "': joint '" + joint.name + "': ";
  if (joint.name.empty()) reject(joint.where, "mechanism '" + mechanism.name + "': a joint without a name");
  if (joint.child >= scene.bodies.size()) reject(name, "no such child");
  if (joint.parent != kNoObject && joint.parent >= scene.bodies.size()) reject(name, "no such parent");
  if (joint.parent == joint.child) reject(name, "parent and child are one object");
  if (!touchstone::is_finite(joint.p_W) || !touchstone::is_finite(joint.axis_W) ||
      !(std::abs(norm(joint.axis_W) - 1.0) <= 1e-9))
    reject(name, "position or axis is not finite, or the axis is not unit");
  if (!(joint.lower <= joint.upper)) reject(name, "the limits are crossed or not numbers");
  if (!is_number_at_least_0(joint.most_rate)) reject(name, "a rate limit below 0");
  if (!is_number_at_least_0(joint.effort)) reject(name, "a torque limit below 0");
  if (!std::isfinite(joint.value) || !std::isfinite(joint.rate)) reject(name, "value or rate is not finite");
  if (joint.value < joint.lower || joint.value > joint.upper) reject(name, "the value is out of its limits");
  validate_drive(joint.drive, name);
  if (joint.kind == JointKind::fixed && is_driven(joint.drive)) reject(name, "a fixed joint has no drive");
  validate_losses(joint.losses, name);
  if (!is_number_at_least_0(joint.rotor) || std::isinf(joint.rotor))
    reject(name, "a rotor's inertia below 0");
}

void validate(const DynamicScene& scene) {
  touchstone::validate(scene.scene);
  // Bodies, mechanisms and links must fit together.
  const std::string name = "scene '" + scene.scene.name + "': ";
  if (scene.bodies.size() != scene.scene.objects.size()) reject(name, "one body an object is needed");
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) validate_body(scene, i);
  std::vector<std::string> moved_by(scene.bodies.size());
  for (const SceneMechanism& mechanism : scene.mechanisms) validate_mechanism(scene, mechanism, moved_by);
  validate_links(scene, moved_by);
  // Pairs, joints between bodies, actions and latches refer to them.
  validate_pairs(scene);
  validate_body_joints(scene);
  validate_actions(scene);
  validate_latch_options(scene);
  // Settings must be finite and in range.
  if (!touchstone::is_finite(scene.gravity_W)) reject(name, "gravity is not finite");
  if (!(scene.step > 0.0) || !std::isfinite(scene.step)) reject(name, "the step is not above 0");
  // Two figures from a file and their quotient: a whole number to rounding.
  const double steps = scene.scene.duration / scene.step;
  if (!(std::abs(steps - std::round(steps)) <= 0x1p-50 * steps) || steps < 0.5 || steps > 1e9)
    reject(name, "the step does not divide the duration into 1 to 1e9 steps");
  if (!(scene.contact_margin > scene.scene.contact_gap) || !std::isfinite(scene.contact_margin))
    reject(name, "the contact margin is not above the contact gap");
  for (const double figure : {scene.bounce_speed, scene.push_out, scene.part_speed, scene.sleep_speed})
    if (!is_number_at_least_0(figure) || std::isinf(figure))
      reject(name, "bounce speed, push-out, part speed and sleep speed must be >= 0 and finite");
  if (!is_number_at_least_0(scene.sleep_time)) reject(name, "the sleep time must be >= 0");
  // Answers and acceptance come last.
  for (const SceneAnswer& answer : scene.answers) validate_answer(scene, answer);
  validate_accept(scene, name);
}

}  // namespace touchstone::physics
