#include "touchstone/adapters/scene_files/dynamics_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/adapters/scene_files/arm_reader.hpp"
#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using physics::BodyInertia;
using physics::BodyKind;
using physics::DynamicScene;
using physics::JointAddress;
using physics::JointDrive;
using physics::SceneAction;
using physics::SceneAnswer;
using physics::SceneBody;
using physics::SceneDrive;
using physics::SceneJoint;
using physics::SceneMechanism;
using scene_files::read_positive;
using scene_files::YamlReader;
using scene_files::YamlSource;

std::string in_quotes(const std::string& name) { return "'" + name + "'"; }

std::string where(const YamlReader& reader) { return reader.file_and_line() + ": "; }

/// Runs f; what physics refuses gets this node's file and line.
template <typename F>
auto located(const YamlReader& reader, F&& f) {
  try {
    return f();
  } catch (const InputError& error) {
    reader.fail_bare(error.what());
  }
}

/// The same node, its errors prefixed by `what` alone.
YamlReader called(const YamlReader& reader, const std::string& what) {
  return {reader.node(), reader.source(), what + ": "};
}

std::size_t read_object(const YamlReader& reader, const Scene& scene) {
  const std::size_t object = find_object(scene, reader.text());
  if (object == kNoObject) reader.fail("the scene has no object " + in_quotes(reader.text()));
  return object;
}

double read_at_least_0(const YamlReader& reader, double value) {
  if (!(value >= 0.0)) reader.fail("must be >= 0");
  return value;
}

/// Of a joint: an angle where it turns, a length where it shifts.
double read_joint_figure(const YamlReader& reader, JointKind kind) {
  return kind == JointKind::revolute ? reader.angle() : reader.length();
}

Vector3 read_turn(const YamlReader& reader) { return reader.vector3() * reader.source().radians_per_angle; }

// ---- bodies

BodyInertia read_rod(const YamlReader& reader, double mass) {
  const std::vector<YamlReader> ends = reader.list();
  if (ends.size() != 2) reader.fail("expected two ends, got " + std::to_string(ends.size()));
  const Vector3 from = ends[0].length3(), to = ends[1].length3(), along = to - from;
  const Matrix3 I = mass / 12.0 * (dot(along, along) * Matrix3::Identity() - outer(along, along));
  return {mass, 0.5 * (from + to), I};
}

BodyInertia read_given(const YamlReader& reader, double mass) {
  BodyInertia out{mass, Vector3::Zero(), Matrix3::Zero()};
  if (reader.has("centre")) out.centre_B = reader.at("centre").length3();
  out.inertia_B.diagonal() = reader.at("moments").vector3();
  if (!reader.has("products")) return out;
  const Vector3 products = reader.at("products").vector3();
  out.inertia_B(0, 1) = out.inertia_B(1, 0) = products.x();
  out.inertia_B(0, 2) = out.inertia_B(2, 0) = products.y();
  out.inertia_B(1, 2) = out.inertia_B(2, 1) = products.z();
  return out;
}

BodyInertia read_inertia(const YamlReader& reader, const HexahedronTree& tree) {
  const std::string name = "object " + in_quotes(tree.name());
  if (reader.has("mass") == reader.has("density")) reader.fail("expected one of mass, density");
  if (reader.has("density")) {
    if (reader.has("inertia")) reader.fail("with a density the inertia is that of the hexahedra");
    return located(reader.at("density"), [&] {
      return physics::inertia_of_density(tree.solids(), reader.at("density").number(), name);
    });
  }
  const double mass = reader.at("mass").number();
  if (!reader.has("inertia")) {
    if (mass == 0.0) return {};  // of a link: validate_body() refuses it of others
    return located(reader.at("mass"), [&] { return physics::inertia_of_mass(tree.solids(), mass, name); });
  }
  const YamlReader inertia = reader.at("inertia");
  inertia.require_keys({"centre", "moments", "products", "rod", "point"});
  if (int{inertia.has("moments")} + int{inertia.has("rod")} + int{inertia.has("point")} != 1)
    inertia.fail("expected one of moments, rod, point");
  if (!inertia.has("moments") && (inertia.has("centre") || inertia.has("products")))
    inertia.fail("centre and products go with moments");
  if (inertia.has("rod")) return read_rod(inertia.at("rod"), mass);
  if (inertia.has("point")) return {mass, inertia.at("point").length3(), Matrix3::Zero()};
  return read_given(inertia, mass);
}

BodyKind read_kind(const YamlReader& reader, bool is_link) {
  if (!reader.has("kind")) {
    if (!is_link) reader.fail("missing 'kind'");
    return BodyKind::link;
  }
  const YamlReader kind = reader.at("kind");
  if (is_link) kind.fail("a joint moves it: it has no kind");
  for (const BodyKind each : {BodyKind::fixed, BodyKind::kinematic, BodyKind::dynamic})
    if (kind.text() == to_string(each)) return each;
  kind.fail("unknown kind " + in_quotes(kind.text()) + "; known: static, kinematic, dynamic");
}

void read_surface(const YamlReader& reader, physics::Surface& surface) {
  if (reader.has("friction"))
    surface.friction = read_at_least_0(reader.at("friction"), reader.at("friction").number());
  if (!reader.has("restitution")) return;
  surface.restitution = reader.at("restitution").number();
  if (!(surface.restitution >= 0.0 && surface.restitution <= 1.0))
    reader.at("restitution").fail("must be from 0 to 1");
}

/// An object; or those of a group, as copies are.
std::vector<std::size_t> read_objects(const YamlReader& reader, const Scene& scene) {
  const std::string name = reader.text();
  std::vector<std::size_t> objects;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::vector<std::string>& groups = scene.objects[i].groups;
    if (scene.objects[i].tree.name() == name || std::find(groups.begin(), groups.end(), name) != groups.end())
      objects.push_back(i);
  }
  if (objects.empty()) reader.fail("the scene has no object " + in_quotes(name));
  return objects;
}

void read_body(const YamlReader& item, std::size_t object, DynamicScene& out,
               std::vector<std::uint8_t>& is_listed) {
  const HexahedronTree& tree = out.scene.objects[object].tree;
  const YamlReader reader = called(item, "object " + in_quotes(tree.name()));
  if (is_listed[object] != 0) reader.fail("its body occurs twice");
  is_listed[object] = 1;
  SceneBody& body = out.bodies[object];
  body.where = where(item);
  body.kind = read_kind(reader, body.kind == BodyKind::link);
  read_surface(reader, body.surface);
  const bool has_mass = body.kind == BodyKind::dynamic || body.kind == BodyKind::link;
  if (has_mass) body.inertia = read_inertia(reader, tree);
  for (const char* key : {"mass", "density", "inertia"})
    if (!has_mass && reader.has(key))
      reader.at(key).fail("is not asked of what is " + std::string(to_string(body.kind)));
  for (const char* key : {"velocity", "turn"})
    if (body.kind != BodyKind::dynamic && reader.has(key))
      reader.at(key).fail(
          "only dynamic bodies start with one; kinematic ones have a motion, links joint rates");
  if (reader.has("velocity")) body.v_W = reader.at("velocity").length3();
  if (reader.has("turn")) body.w_W = read_turn(reader.at("turn"));
  physics::validate_body(out, object);
}

void read_bodies(const YamlReader& dynamics, DynamicScene& out) {
  std::vector<std::uint8_t> is_listed(out.bodies.size(), 0);
  if (dynamics.has("bodies"))
    for (const YamlReader& item : dynamics.at("bodies").list()) {
      item.require_keys(
          {"object", "kind", "mass", "density", "inertia", "velocity", "turn", "friction", "restitution"});
      for (const std::size_t object : read_objects(called(item, "dynamics: bodies").at("object"), out.scene))
        read_body(item, object, out, is_listed);
    }
  for (std::size_t i = 0; i < out.bodies.size(); ++i)
    if (out.bodies[i].kind == BodyKind::link && is_listed[i] == 0)
      dynamics.fail("object " + in_quotes(out.scene.objects[i].tree.name()) +
                    " is a link: 'bodies' does not tell its mass");
}

void read_rule(const YamlReader& reader, physics::Combination& rule) {
  std::string known;
  for (std::size_t i = 0; i < physics::kCombinations; ++i) {
    const auto each = static_cast<physics::Combination>(i);
    known += (known.empty() ? "" : ", ") + std::string(to_string(each));
    if (reader.text() != to_string(each)) continue;
    rule = each;
    return;
  }
  reader.fail("unknown rule " + in_quotes(reader.text()) + "; known: " + known);
}

/// Surfaces that meet by other rules than their own figures'.
void read_pairs(const YamlReader& dynamics, DynamicScene& out) {
  if (dynamics.has("combine")) {
    const YamlReader rules = dynamics.at("combine");
    rules.require_keys({"friction", "restitution"});
    if (rules.has("friction")) read_rule(rules.at("friction"), out.friction_rule);
    if (rules.has("restitution")) read_rule(rules.at("restitution"), out.restitution_rule);
  }
  // Figures of pairs: every object of one name with every one of the other.
  if (!dynamics.has("pairs")) return;
  for (const YamlReader& item : dynamics.at("pairs").list()) {
    item.require_keys({"between", "friction", "restitution"});
    if (!item.has("friction") && !item.has("restitution"))
      item.fail("expected friction, restitution or both");
    const std::vector<YamlReader> names = item.at("between").list();
    if (names.size() != 2) item.at("between").fail("expected two objects or groups");
    physics::Surface surface;
    read_surface(item, surface);
    physics::ScenePair pair;
    pair.where = where(item);
    if (item.has("friction")) pair.friction = surface.friction;
    if (item.has("restitution")) pair.restitution = surface.restitution;
    const std::size_t before = out.pairs.size();
    const std::vector<std::size_t> second = read_objects(names[1], out.scene);
    for (const std::size_t a : read_objects(names[0], out.scene))
      for (const std::size_t b : second) {
        if (a == b) continue;
        pair.a = a, pair.b = b;
        out.pairs.push_back(pair);
      }
    if (out.pairs.size() == before) item.at("between").fail("an object is no pair with itself");
  }
}

// ---- mechanisms

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

// ---- joints between bodies

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

bool read_yes(const YamlReader& reader) {
  if (reader.text() == "true") return true;
  if (reader.text() == "false") return false;
  reader.fail("expected true or false");
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
  if (reader.has("holds")) joint.is_on = read_yes(reader.at("holds"));
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

/// `mechanism.joint`.
JointAddress read_joint_name(const YamlReader& reader, const DynamicScene& scene) {
  const std::string& text = reader.text();
  for (std::size_t m = 0; m < scene.mechanisms.size(); ++m)
    for (std::size_t j = 0; j < scene.mechanisms[m].joints.size(); ++j)
      if (text == scene.mechanisms[m].name + "." + scene.mechanisms[m].joints[j].name) return {m, j};
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (text == scene.joints[j].name) return {JointAddress::kBodyJoint, j};
  reader.fail("the scene has no joint " + in_quotes(text) + " (mechanism.joint)");
}

// ---- actions

/// Of any joint that moves.
void read_drive_action(const YamlReader& drive, const DynamicScene& scene, SceneAction& action) {
  drive.require_keys(
      {"joint", "torque", "ramp", "rate", "brake", "limit", "position", "stiffness", "damping"});
  action.joint = read_joint_name(drive.at("joint"), scene);
  if (kind_of(scene, action.joint) == JointKind::fixed) drive.at("joint").fail("is fixed");
  action.drive = read_drive(drive, kind_of(scene, action.joint));
}

/// A value, of an arm's joint.
void read_set_action(const YamlReader& set, const DynamicScene& scene, SceneAction& action) {
  set.require_keys({"joint", "value", "rate"});
  action.kind = SceneAction::Kind::set_joint;
  // The joint is one of a mechanism that moves.
  action.joint = read_joint_name(set.at("joint"), scene);
  if (action.joint.is_of_bodies()) set.at("joint").fail("is no joint of a mechanism");
  const SceneJoint& joint = scene.mechanisms[action.joint.mechanism].joints[action.joint.joint];
  if (joint.kind == JointKind::fixed) set.at("joint").fail("is fixed");
  // Its value stays within the limits.
  action.value = read_joint_figure(set.at("value"), joint.kind);
  if (!(action.value >= joint.lower && action.value <= joint.upper))
    set.at("value").fail("is out of the joint's limits");
  if (set.has("rate")) action.rate = read_joint_figure(set.at("rate"), joint.kind);
}

/// Latches name who carries whom.
void read_latch_action(const YamlReader& latch, const DynamicScene& scene, SceneAction& action) {
  latch.require_keys({"carrier", "carried", "allowed"});
  action.kind = SceneAction::Kind::latch;
  action.carrier = read_object(latch.at("carrier"), scene.scene);
  action.carried = read_object(latch.at("carried"), scene.scene);
  if (latch.has("allowed")) action.allowed = scene_files::read_exempt_pairs(latch.at("allowed"), scene.scene);
}

SceneAction read_action(const YamlReader& item, const DynamicScene& scene) {
  // One action an item, so that its kind is never in doubt.
  const std::array<const char*, 8> kinds{"drive", "latch", "release", "set", "join", "part", "add", "remove"};
  item.require_keys({"time", "drive", "latch", "release", "set", "join", "part", "add", "remove"});
  if (std::count_if(kinds.begin(), kinds.end(), [&](const char* kind) { return item.has(kind); }) != 1)
    item.fail("expected one of drive, latch, release, set, join, part, add, remove");
  SceneAction action;
  action.where = where(item);
  action.time = read_at_least_0(item.at("time"), item.at("time").number());
  // Drives, values and latches have keys of their own.
  if (item.has("drive")) read_drive_action(item.at("drive"), scene, action);
  if (item.has("set")) read_set_action(item.at("set"), scene, action);
  if (item.has("latch")) read_latch_action(item.at("latch"), scene, action);
  // Joints between bodies are joined and parted by name.
  for (const auto& [key, kind] :
       {std::pair("join", SceneAction::Kind::join), std::pair("part", SceneAction::Kind::part)}) {
    if (!item.has(key)) continue;
    action.kind = kind;
    action.joint = read_joint_name(item.at(key), scene);
    if (!action.joint.is_of_bodies()) item.at(key).fail("is no joint between bodies");
  }
  // So are objects that are released, come in or go out.
  for (const auto& [key, kind] :
       {std::pair("release", SceneAction::Kind::release), std::pair("add", SceneAction::Kind::add),
        std::pair("remove", SceneAction::Kind::remove)}) {
    if (!item.has(key)) continue;
    action.kind = kind;
    action.carried = read_object(item.at(key), scene.scene);
  }
  return action;
}

// ---- what the scene comes to

SceneAnswer::Figure read_figure(const YamlReader& reader) {
  std::string known;
  for (auto i = SceneAnswer::Figure::position; i <= SceneAnswer::Figure::stopped;
       i = static_cast<SceneAnswer::Figure>(static_cast<int>(i) + 1)) {
    if (reader.text() == to_string(i)) return i;
    known += (known.empty() ? "" : ", ") + std::string(to_string(i));
  }
  reader.fail("unknown figure " + in_quotes(reader.text()) + "; known: " + known);
}

/// SI figures for one of the file's.
double unit_of_figure(const SceneAnswer& answer, const DynamicScene& scene, const YamlSource& source) {
  using Figure = SceneAnswer::Figure;
  const double length = 1.0 / source.lengths_per_metre, angle = source.radians_per_angle;
  if (answer.figure == Figure::position || answer.figure == Figure::velocity) return length;
  if (answer.figure == Figure::angular_velocity) return angle;
  if (answer.figure == Figure::value || answer.figure == Figure::rate)
    return kind_of(scene, answer.joint) == JointKind::revolute ? angle : length;
  return 1.0;
}

SceneAnswer read_answer(const YamlReader& item, const DynamicScene& scene) {
  item.require_keys({"of", "figure", "time", "value", "tolerance"});
  SceneAnswer answer;
  answer.where = where(item);
  // The figure decides whether an object or a joint is named.
  answer.figure = read_figure(item.at("figure"));
  if (answer.is_vector()) answer.object = read_object(item.at("of"), scene.scene);
  if (answer.is_of_joint()) answer.joint = read_joint_name(item.at("of"), scene);
  // Only dynamic bodies have velocities to be judged.
  const bool is_dynamic = answer.is_vector() && scene.bodies[answer.object].kind == BodyKind::dynamic;
  if ((answer.figure == SceneAnswer::Figure::velocity ||
       answer.figure == SceneAnswer::Figure::angular_velocity) &&
      !is_dynamic)
    item.at("of").fail("is not dynamic: it has no such figure");
  // Figures are those at the end, unless a time is given.
  const bool is_a_time =
      answer.figure == SceneAnswer::Figure::moved || answer.figure == SceneAnswer::Figure::stopped;
  answer.time = scene.scene.duration;
  if (item.has("time")) {
    if (is_a_time) item.at("time").fail("the figure is a time itself");
    answer.time = item.at("time").number();
    if (!(answer.time > 0.0 && answer.time <= scene.scene.duration))
      item.at("time").fail("is not within the scene's duration");
  }
  // Value and tolerance are in the file's units.
  const double unit = unit_of_figure(answer, scene, item.source());
  if (answer.is_vector())
    answer.value = unit * item.at("value").vector3();
  else
    answer.value.x() = unit * item.at("value").number();
  answer.tolerance = unit * read_positive(item.at("tolerance"), item.at("tolerance").number());
  return answer;
}

void read_conserved(const YamlReader& reader, DynamicScene& out) {
  for (const YamlReader& item : reader.list()) {
    const std::string& what = item.text();
    if (what == "momentum") {
      out.conserved.linear = true;
    } else if (what == "angular_momentum") {
      out.conserved.angular = {true, true, true};
    } else if (what == "energy") {
      out.conserved.energy = true;
    } else if (what.starts_with("angular_momentum_") && what.size() == 18 && what[17] >= 'x' &&
               what[17] <= 'z') {
      out.conserved.angular[static_cast<std::size_t>(what[17] - 'x')] = true;
    } else {
      item.fail("unknown " + in_quotes(what) +
                "; known: momentum, angular_momentum, angular_momentum_x, _y, _z, energy");
    }
  }
}

void read_accept(const YamlReader& reader, DynamicScene& out) {
  reader.require_keys({"depth", "position", "angle", "energy_made", "rest"});
  const auto read = [&](const char* key, double unit, double& value) {
    if (!reader.has(key)) return;
    const bool is_any = reader.at(key).node().IsScalar() && reader.at(key).node().Scalar() == "any";
    value = is_any ? kInfinity : unit * read_at_least_0(reader.at(key), reader.at(key).number());
  };
  const double length = 1.0 / reader.source().lengths_per_metre;
  read("depth", length, out.accept.depth);
  read("position", length, out.accept.position);
  read("angle", reader.source().radians_per_angle, out.accept.angle);
  read("energy_made", 1.0, out.accept.energy_made);
  read("rest", length, out.accept.rest);
}

// ---- all of it

void read_settings(const YamlReader& dynamics, DynamicScene& out) {
  if (dynamics.has("gravity")) out.gravity_W = dynamics.at("gravity").length3();
  out.step = read_positive(dynamics.at("step"), dynamics.at("step").number());
  const double steps = out.scene.duration / out.step;
  if (!(std::abs(steps - std::round(steps)) <= 0x1p-50 * steps) || steps < 0.5)
    dynamics.at("step").fail("does not divide the duration into whole steps");
  if (dynamics.has("contact_margin")) {
    const YamlReader margin = dynamics.at("contact_margin");
    out.contact_margin = read_positive(margin, margin.length());
    if (!(out.contact_margin > out.scene.contact_gap)) margin.fail("is not above the contact gap");
  }
  const auto read = [&](const char* key, double unit, double& value) {
    if (dynamics.has(key)) value = unit * read_at_least_0(dynamics.at(key), dynamics.at(key).number());
  };
  const double length = 1.0 / dynamics.source().lengths_per_metre;
  read("bounce_speed", length, out.bounce_speed);
  read("push_out", 1.0, out.push_out);
  read("part_speed", length, out.part_speed);
  read("sleep_speed", length, out.sleep_speed);
  read("sleep_time", 1.0, out.sleep_time);
}

DynamicScene read_dynamics(const YamlReader& dynamics, Scene scene) {
  dynamics.require_keys(
      {"gravity",      "step",     "contact_margin", "friction",    "restitution", "combine", "pairs",
       "bounce_speed", "push_out", "part_speed",     "sleep_speed", "sleep_time",  "bodies",  "mechanisms",
       "joints",       "arms",     "actions",        "answers",     "conserved",   "accept",  "guard"});
  DynamicScene out;
  out.scene = std::move(scene);
  read_settings(dynamics, out);
  // Objects with a motion are kinematic unless `bodies` says otherwise.
  SceneBody usual;
  usual.where = where(dynamics);
  read_surface(dynamics, usual.surface);
  out.bodies.assign(out.scene.objects.size(), usual);
  for (std::size_t i = 0; i < out.bodies.size(); ++i) {
    if (!out.scene.objects[i].motion.at_rest()) out.bodies[i].kind = BodyKind::kinematic;
  }
  // Mechanisms first: bodies, joints and actions name their links.
  if (dynamics.has("mechanisms")) read_mechanisms(dynamics, out);
  read_bodies(dynamics, out);
  if (dynamics.has("arms")) scene_files::read_arms(dynamics.at("arms"), out);
  if (dynamics.has("joints"))
    for (const YamlReader& item : dynamics.at("joints").list()) read_body_joint(item, out);
  read_pairs(dynamics, out);
  if (dynamics.has("actions"))
    for (const YamlReader& item : dynamics.at("actions").list())
      out.actions.push_back(read_action(item, out));
  if (dynamics.has("answers"))
    for (const YamlReader& item : dynamics.at("answers").list())
      out.answers.push_back(read_answer(item, out));
  if (dynamics.has("conserved")) read_conserved(dynamics.at("conserved"), out);
  if (dynamics.has("accept")) read_accept(dynamics.at("accept"), out);
  return out;
}

}  // namespace

DynamicScene load_dynamic_scene(const std::filesystem::path& path, const SceneParameters& parameters,
                                const ArmModels& arm_models) {
  Scene scene = load_scene(path, parameters);
  YamlSource source;
  source.arm_models = arm_models;
  source.file = path.string();
  const YAML::Node document = scene_files::parse_yaml(path);
  const YamlReader root(document, source);
  scene_files::read_units(root, source);
  scene_files::read_parameters(root, {}, source);
  const bool answers_hold = source.parameters == scene.parameters;
  source.parameters = scene.parameters;
  if (!root.has("dynamics")) throw InputError(source.file + ": the scene asks for no dynamics");
  DynamicScene out = read_dynamics(root.at("dynamics"), std::move(scene));
  out.answers_hold = answers_hold;
  try {
    physics::validate(out);
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    if (message.starts_with(source.file + ":")) throw;
    throw InputError(source.file + ": " + std::string(message));
  }
  return out;
}

}  // namespace touchstone
