#include "touchstone/adapters/scene_files/dynamics/parts.hpp"

namespace touchstone::scene_files {
namespace {

using physics::BodyKind;
using physics::DynamicScene;
using physics::JointAddress;
using physics::JointDrive;
using physics::SceneDrive;
using physics::SceneJoint;
using physics::SceneMechanism;

JointKind read_joint_kind(const YamlReader& reader) {
  for (const JointKind kind : {JointKind::fixed, JointKind::revolute, JointKind::prismatic})
    if (reader.text() == to_string(kind)) return kind;
  reader.fail("unknown kind " + in_quotes(reader.text()) + "; known: fixed, revolute, prismatic");
}

void read_limits(const YamlReader& reader, SceneJoint& joint) {
  reader.require_keys({"position", "rate", "torque"});
  if (reader.has("position")) {
    const std::vector<YamlReader> ends = reader.at("position").list();
    if (ends.size() != 2)
      reader.at("position").fail("expected the lower and the upper one, got " + std::to_string(ends.size()));
    joint.lower = read_joint_figure(ends[0], joint.kind);
    joint.upper = read_joint_figure(ends[1], joint.kind);
  }
  if (reader.has("rate"))
    joint.most_rate = read_at_least_0(reader.at("rate"), read_joint_figure(reader.at("rate"), joint.kind));
  if (reader.has("torque")) joint.effort = read_at_least_0(reader.at("torque"), reader.at("torque").number());
}

void read_losses(const YamlReader& reader, physics::JointLosses& losses) {
  if (reader.has("friction"))
    losses.friction = read_at_least_0(reader.at("friction"), reader.at("friction").number());
  if (reader.has("damping"))
    losses.damping = read_at_least_0(reader.at("damping"), reader.at("damping").number());
}

SceneDrive read_joint_drive(const YamlReader& reader, JointKind kind) {
  reader.require_keys({"torque", "ramp", "rate", "brake", "limit", "position", "stiffness", "damping"});
  return read_drive(reader, kind);
}

SceneJoint read_joint(const YamlReader& item, const std::string& mechanism, const Scene& scene) {
  item.require_keys({"name", "kind", "parent", "child", "position", "axis", "value", "rate", "limits",
                     "drive", "friction", "damping", "rotor"});
  SceneJoint joint;
  joint.where = where(item);
  joint.name = called(item, "mechanism " + in_quotes(mechanism)).at("name").text();
  const YamlReader reader =
      called(item, "mechanism " + in_quotes(mechanism) + ": joint " + in_quotes(joint.name));
  if (joint.name.find('.') != std::string::npos) reader.fail("a joint's name has no '.'");
  joint.kind = read_joint_kind(reader.at("kind"));
  if (reader.has("parent")) joint.parent = read_object(reader.at("parent"), scene);
  joint.child = read_object(reader.at("child"), scene);
  if (joint.kind == JointKind::fixed) {
    for (const char* key :
         {"position", "axis", "value", "rate", "limits", "drive", "friction", "damping", "rotor"})
      if (reader.has(key)) reader.at(key).fail("a fixed joint has none");
    return joint;
  }
  // Place and axis, in the world at the scene's start.
  if (joint.kind == JointKind::revolute || reader.has("position"))
    joint.p_W = reader.at("position").length3();
  else
    joint.p_W = scene.objects[joint.child].X_WO.p;
  const Vector3 axis = reader.at("axis").vector3();
  if (norm(axis) == 0.0) reader.at("axis").fail("the axis is zero");
  joint.axis_W = axis / norm(axis);
  // State, limits, losses and drive.
  if (reader.has("value")) joint.value = read_joint_figure(reader.at("value"), joint.kind);
  if (reader.has("rate")) joint.rate = read_joint_figure(reader.at("rate"), joint.kind);
  if (reader.has("limits")) read_limits(reader.at("limits"), joint);
  read_losses(reader, joint.losses);
  if (reader.has("rotor")) joint.rotor = read_at_least_0(reader.at("rotor"), reader.at("rotor").number());
  if (reader.has("drive")) joint.drive = read_joint_drive(reader.at("drive"), joint.kind);
  return joint;
}

physics::BodyJointKind read_body_joint_kind(const YamlReader& reader) {
  using physics::BodyJointKind;
  const std::pair<std::string_view, BodyJointKind> kinds[] = {{"fixed", BodyJointKind::fixed},
                                                              {"revolute", BodyJointKind::hinge},
                                                              {"prismatic", BodyJointKind::slider},
                                                              {"ball", BodyJointKind::ball}};
  for (const auto& [name, kind] : kinds)
    if (reader.text() == name) return kind;
  reader.fail("unknown kind " + in_quotes(reader.text()) + "; known: fixed, revolute, prismatic, ball");
}

}  // namespace

SceneDrive read_drive(const YamlReader& reader, JointKind kind) {
  SceneDrive out;
  // One kind of drive, and what goes with it.
  const bool is_position = reader.has("position");
  if (int{reader.has("torque")} + int{reader.has("rate") && !is_position} + int{reader.has("brake")} +
          int{is_position} !=
      1)
    reader.fail("expected one of torque, rate, brake, position");
  for (const char* key : {"stiffness", "damping"})
    if (reader.has(key) && !is_position) reader.at(key).fail("goes with a position");
  if (reader.has("ramp") && !reader.has("torque")) reader.at("ramp").fail("only a torque has one");
  // Figures, each with its own conditions.
  if (reader.has("limit")) {
    if (reader.has("brake")) reader.at("limit").fail("a brake's limit is its figure");
    out.drive.limit = read_at_least_0(reader.at("limit"), reader.at("limit").number());
  }
  if (reader.has("torque")) out.drive.torque = reader.at("torque").number();
  if (reader.has("ramp")) out.ramp = reader.at("ramp").number();
  if (reader.has("rate")) {
    out.drive.mode = JointDrive::Mode::rate;
    out.drive.rate = read_joint_figure(reader.at("rate"), kind);
  }
  // A position is held by a spring and a damper.
  if (is_position) {
    const auto figure = [&](const char* key) {
      return reader.has(key) ? read_at_least_0(reader.at(key), reader.at(key).number()) : 0.0;
    };
    out.drive.mode = JointDrive::Mode::position;
    out.drive.position = read_joint_figure(reader.at("position"), kind);
    out.drive.stiffness = figure("stiffness");
    out.drive.damping = figure("damping");
    if (out.drive.stiffness == 0.0 && out.drive.damping == 0.0)
      reader.fail("a position needs a stiffness or a damping");
  }
  if (reader.has("brake")) {
    out.drive.mode = JointDrive::Mode::brake;
    out.drive.limit = read_at_least_0(reader.at("brake"), reader.at("brake").number());
  }
  return out;
}

void read_body_joint(const YamlReader& item, DynamicScene& out) {
  item.require_keys({"name", "kind", "parent", "child", "position", "axis", "limits", "friction", "damping",
                     "drive", "holds"});
  // The name comes first, so that errors can tell which joint it is.
  physics::SceneBodyJoint joint;
  joint.where = where(item);
  joint.name = called(item, "dynamics: joints").at("name").text();
  const YamlReader reader = called(item, "joint " + in_quotes(joint.name));
  // All kinds have two sides and a place.
  joint.kind = read_body_joint_kind(reader.at("kind"));
  if (reader.has("parent")) joint.parent = read_object(reader.at("parent"), out.scene);
  joint.child = read_object(reader.at("child"), out.scene);
  joint.p_W =
      reader.has("position") ? reader.at("position").length3() : out.scene.objects[joint.child].X_WO.p;
  if (reader.has("holds")) joint.is_on = read_choice(reader.at("holds"));
  // Balls and fixed joints have no axis, and none of its figures.
  const bool turns = joint.kind == physics::BodyJointKind::hinge;
  if (!turns && joint.kind != physics::BodyJointKind::slider) {
    for (const char* key : {"axis", "limits", "drive", "friction", "damping"})
      if (reader.has(key)) reader.at(key).fail("only joints with an axis have any");
    out.joints.push_back(joint);
    return;
  }
  // Hinges and sliders have limits, losses and a drive along their axis.
  const Vector3 axis = reader.at("axis").vector3();
  if (norm(axis) == 0.0) reader.at("axis").fail("the axis is zero");
  joint.axis_W = axis / norm(axis);
  SceneJoint figures;  // the same keys
  figures.kind = turns ? JointKind::revolute : JointKind::prismatic;
  if (reader.has("limits")) {
    if (reader.at("limits").has("rate")) reader.at("limits").at("rate").fail("is of joints of mechanisms");
    read_limits(reader.at("limits"), figures);
  }
  joint.lower = figures.lower, joint.upper = figures.upper, joint.effort = figures.effort;
  read_losses(reader, joint.losses);
  if (reader.has("drive")) joint.drive = read_joint_drive(reader.at("drive"), figures.kind);
  out.joints.push_back(joint);
}

void read_mechanisms(const YamlReader& dynamics, DynamicScene& out) {
  for (const YamlReader& item : dynamics.at("mechanisms").list()) {
    item.require_keys({"name", "joints"});
    SceneMechanism mechanism;
    mechanism.where = where(item);
    mechanism.name = item.at("name").text();
    for (const SceneMechanism& other : out.mechanisms)
      if (other.name == mechanism.name) item.fail("the mechanism " + in_quotes(other.name) + " occurs twice");
    for (const YamlReader& joint :
         called(item, "mechanism " + in_quotes(mechanism.name)).at("joints").list()) {
      mechanism.joints.push_back(read_joint(joint, mechanism.name, out.scene));
      physics::validate_joint(out, mechanism, mechanism.joints.back());
      out.bodies[mechanism.joints.back().child].kind = BodyKind::link;
    }
    out.mechanisms.push_back(std::move(mechanism));
  }
}

JointAddress read_joint_name(const YamlReader& reader, const DynamicScene& scene) {
  const std::string& text = reader.text();
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m)
    for (std::size_t j = 0; j < scene.mechanisms[m].joints.size(); ++j)
      if (text == scene.mechanisms[m].name + "." + scene.mechanisms[m].joints[j].name) return {m, j};
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (text == scene.joints[j].name) return {JointAddress::kBodyJoint, j};
  reader.fail("the scene has no joint " + in_quotes(text) + " (mechanism.joint)");
}

}  // namespace touchstone::scene_files
