#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/dynamic_scenes.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/scene/joint_names.hpp"
#ifdef TOUCHSTONE_HAS_DYNAMICS_FILES
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#endif

// Scenes of dynamics: bodies, joints and actions, by hand or from a file.

namespace touchstone::python {
namespace {

using namespace touchstone::physics;

/// The value of that name. @throws InputError naming the known ones.
template <class Value, std::size_t count>
Value named(const std::pair<const char*, Value> (&known)[count], const std::string& name, const char* what) {
  std::string names;
  for (const auto& [each, value] : known) {
    if (name == each) return value;
    names += (names.empty() ? "" : ", ") + std::string(each);
  }
  reject(what, "'" + name + "' is none of " + names);
}

constexpr std::pair<const char*, BodyKind> kBodyKinds[] = {
    {"static", BodyKind::fixed}, {"dynamic", BodyKind::dynamic}, {"link", BodyKind::link}};
constexpr std::pair<const char*, JointKind> kJointKinds[] = {
    {"fixed", JointKind::fixed}, {"revolute", JointKind::revolute}, {"prismatic", JointKind::prismatic}};
// As scene files have them.
constexpr std::pair<const char*, BodyJointKind> kBodyJointKinds[] = {{"fixed", BodyJointKind::fixed},
                                                                     {"revolute", BodyJointKind::hinge},
                                                                     {"prismatic", BodyJointKind::slider},
                                                                     {"ball", BodyJointKind::ball}};
constexpr std::pair<const char*, JointDrive::Mode> kDriveModes[] = {{"torque", JointDrive::Mode::torque},
                                                                    {"rate", JointDrive::Mode::rate},
                                                                    {"brake", JointDrive::Mode::brake},
                                                                    {"position", JointDrive::Mode::position}};
constexpr std::pair<const char*, SceneAction::Kind> kActions[] = {
    {"drive", SceneAction::Kind::drive}, {"set", SceneAction::Kind::set_joint},
    {"latch", SceneAction::Kind::latch}, {"release", SceneAction::Kind::release},
    {"join", SceneAction::Kind::join},   {"part", SceneAction::Kind::part},
    {"add", SceneAction::Kind::add},     {"remove", SceneAction::Kind::remove}};

std::shared_ptr<DynamicScene> make_scene(const std::string& name, double duration, double step,
                                         const py::object& gravity) {
  auto made = std::make_shared<DynamicScene>();
  made->scene.name = name;
  made->scene.units = "SI";
  made->scene.duration = duration;
  made->scene.frame_rate = 1.0 / step;
  made->scene.contact_gap = 1e-9;
  made->step = step;
  made->gravity_W = vector3(gravity, "gravity");
  return made;
}

std::size_t add_body(DynamicScene& self, const HexahedronTree& tree, const py::object& X_WO,
                     const std::string& kind, std::optional<double> mass, std::optional<double> density,
                     const py::object& velocity, const py::object& angular_velocity, double friction,
                     double restitution) {
  SceneBody body;
  body.kind = named(kBodyKinds, kind, "kind");
  if (mass && density) reject(tree.name(), "has a mass and a density");
  if (mass) body.inertia = inertia_of_mass(tree.solids(), *mass, tree.name());
  if (density) body.inertia = inertia_of_density(tree.solids(), *density, tree.name());
  if (body.kind == BodyKind::dynamic && !mass && !density) reject(tree.name(), "is dynamic, and has no mass");
  if (!velocity.is_none()) body.v_W = vector3(velocity, "velocity");
  if (!angular_velocity.is_none()) body.w_W = vector3(angular_velocity, "angular_velocity");
  body.surface = {friction, restitution};
  SceneObject object{tree, pose(X_WO, tree.name().c_str()), {}, {}, body.kind == BodyKind::fixed};
  if (find_object(self.scene, tree.name()) != kNoObject) reject(tree.name(), "is there already");
  self.scene.objects.push_back(std::move(object));
  self.bodies.push_back(std::move(body));
  return self.bodies.size() - 1;
}

// ---- joints

/// None: `none`. @throws InputError: no object of that name.
std::size_t object_of(const DynamicScene& self, const std::optional<std::string>& name, std::size_t none) {
  if (!name) return none;
  const std::size_t found = find_object(self.scene, *name);
  if (found == kNoObject) reject(*name, "is no object of the scene");
  return found;
}

bool has_joint(const DynamicScene& self, const std::string& name) {
  const std::vector<std::string> names = joint_names(self);
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// None: the child's origin.
Vector3 place_of(const DynamicScene& self, const py::object& position, std::size_t child) {
  return position.is_none() ? self.scene.objects[child].X_WO.p : vector3(position, "position");
}

Vector3 axis_of(const py::object& axis) {
  const Vector3 v = vector3(axis, "axis");
  const double length = norm(v);
  if (!(length > 0.0) || !std::isfinite(length)) reject("axis", "has no direction");
  return v / length;
}

SceneDrive make_drive(const std::string& mode, double torque, double rate, double limit, double position,
                      double stiffness, double damping, double ramp) {
  return {{named(kDriveModes, mode, "mode"), torque, rate, limit, position, stiffness, damping}, ramp};
}

/// Arguments that joints of mechanisms and joints between bodies share.
struct GivenJoint {
  const std::string &name, &child;
  const std::optional<std::string>& parent;
  const py::object &position, &axis;
  double lower, upper, effort;
  const SceneDrive& drive;
  double friction, damping;
};

template <class Joint, class Kind>
Joint make_joint(const DynamicScene& self, const GivenJoint& given, Kind kind) {
  Joint joint;
  joint.name = given.name;
  joint.kind = kind;
  joint.child = object_of(self, given.child, kNoObject);
  joint.parent = object_of(self, given.parent, kNoObject);
  joint.p_W = place_of(self, given.position, joint.child);
  joint.axis_W = axis_of(given.axis);
  joint.lower = given.lower, joint.upper = given.upper, joint.effort = given.effort;
  joint.drive = given.drive;
  joint.losses = {given.friction, given.damping};
  return joint;
}

void add_joint(DynamicScene& self, const std::string& mechanism, const std::string& name,
               const std::string& child, const std::optional<std::string>& parent, const std::string& kind,
               const py::object& position, const py::object& axis, double value, double rate, double lower,
               double upper, double most_rate, double effort, const SceneDrive& drive, double friction,
               double damping, double rotor) {
  if (has_joint(self, mechanism + "." + name)) reject(mechanism + "." + name, "is there already");
  const GivenJoint given{name, child, parent, position, axis, lower, upper, effort, drive, friction, damping};
  auto joint = make_joint<SceneJoint>(self, given, named(kJointKinds, kind, "kind"));
  joint.value = value, joint.rate = rate;
  joint.most_rate = most_rate;
  joint.rotor = rotor;
  // The mechanism's first joint makes it.
  auto of = std::find_if(self.mechanisms.begin(), self.mechanisms.end(),
                         [&](const SceneMechanism& each) { return each.name == mechanism; });
  if (of == self.mechanisms.end()) of = self.mechanisms.insert(of, {mechanism, {}, {}});
  of->joints.push_back(std::move(joint));
}

void add_body_joint(DynamicScene& self, const std::string& name, const std::string& child,
                    const std::optional<std::string>& parent, const std::string& kind,
                    const py::object& position, const py::object& axis, double lower, double upper,
                    double effort, const SceneDrive& drive, double friction, double damping, bool holds) {
  if (has_joint(self, name)) reject(name, "is there already");
  const GivenJoint given{name, child, parent, position, axis, lower, upper, effort, drive, friction, damping};
  auto joint = make_joint<SceneBodyJoint>(self, given, named(kBodyJointKinds, kind, "kind"));
  joint.is_on = holds;
  self.joints.push_back(std::move(joint));
}

// ---- actions

void act(DynamicScene& self, double time, const std::string& kind, const std::string& what,
         const std::optional<SceneDrive>& drive, std::optional<double> value, std::optional<double> rate,
         const std::optional<std::string>& carrier,
         const std::vector<std::pair<std::string, std::string>>& allowed) {
  SceneAction action;
  action.kind = named(kActions, kind, "kind");
  action.time = time;
  const bool is_of_joint = action.kind == SceneAction::Kind::drive ||
                           action.kind == SceneAction::Kind::set_joint ||
                           action.kind == SceneAction::Kind::join || action.kind == SceneAction::Kind::part;
  if (is_of_joint)
    action.joint = joint_named(self, what);
  else
    action.carried = object_of(self, what, kNoObject);
  // The kind's own fields are required, and no others are allowed.
  if ((action.kind == SceneAction::Kind::drive) != drive.has_value())
    reject("drive", "is for actions of kind 'drive', which need one");
  if ((action.kind == SceneAction::Kind::latch) != carrier.has_value())
    reject("carrier", "is for actions of kind 'latch', which need one");
  if ((action.kind == SceneAction::Kind::set_joint) != value.has_value())
    reject("value", "is for actions of kind 'set', which need one");
  if (rate && action.kind != SceneAction::Kind::set_joint) reject("rate", "is for actions of kind 'set'");
  if (!allowed.empty() && action.kind != SceneAction::Kind::latch)
    reject("allowed", "is for actions of kind 'latch'");
  if (drive) action.drive = *drive;
  action.value = value.value_or(0.0), action.rate = rate.value_or(0.0);
  if (carrier) action.carrier = object_of(self, carrier, kNoObject);
  for (const auto& [first, second] : allowed) action.allowed.push_back({first, second});
  // By time, those of one time as they were given.
  const auto later = std::upper_bound(self.actions.begin(), self.actions.end(), time,
                                      [](double at, const SceneAction& each) { return at < each.time; });
  self.actions.insert(later, std::move(action));
}

/// A latch that Simulation.latch() may close.
void add_latch_option(DynamicScene& self, const std::string& carried, const std::string& carrier,
                      const std::vector<std::pair<std::string, std::string>>& allowed) {
  SceneLatchOption option;
  option.carried = object_of(self, carried, kNoObject);
  option.carrier = object_of(self, carrier, kNoObject);
  for (const auto& [first, second] : allowed) option.allowed.push_back({first, second});
  self.latch_options.push_back(std::move(option));
}

// ---- names

std::vector<std::string> object_names(const DynamicScene& self) {
  std::vector<std::string> made;
  for (const SceneObject& object : self.scene.objects) made.push_back(object.tree.name());
  return made;
}

using SceneClass = py::class_<DynamicScene, std::shared_ptr<DynamicScene>>;

void bind_joints(SceneClass& scene) {
  scene
      // Joints of trees, and between any bodies.
      .def("add_joint", &add_joint, py::arg("mechanism"), py::arg("name"), py::arg("child"),
           py::arg("parent") = py::none(), py::arg("kind") = "revolute", py::arg("position") = py::none(),
           py::arg("axis") = py::make_tuple(0.0, 0.0, 1.0), py::arg("value") = 0.0, py::arg("rate") = 0.0,
           py::arg("lower") = -kInfinity, py::arg("upper") = kInfinity, py::arg("most_rate") = kInfinity,
           py::arg("effort") = kInfinity, py::arg("drive") = SceneDrive{}, py::arg("friction") = 0.0,
           py::arg("damping") = 0.0, py::arg("rotor") = 0.0,
           "A joint of a mechanism, which its first joint makes: the tree of links that the ground holds. "
           "child: an object of kind 'link'. parent: a link or a static object; None: the ground. kind: "
           "'fixed', 'revolute' [rad, N m], 'prismatic' [m, N]. position (3,): a point of the axis while all "
           "stand in their initial poses, None: the child's origin; axis (3,), of any length. value, rate: "
           "there, at the start. friction: Coulomb's [N m] or [N]; damping [N m s/rad] or [N s/m]; rotor "
           "[kg m2] or [kg]. Named 'mechanism.name' from then on.")
      .def(
          "add_body_joint", &add_body_joint, py::arg("name"), py::arg("child"),
          py::arg("parent") = py::none(), py::arg("kind") = "fixed", py::arg("position") = py::none(),
          py::arg("axis") = py::make_tuple(0.0, 0.0, 1.0), py::arg("lower") = -kInfinity,
          py::arg("upper") = kInfinity, py::arg("effort") = kInfinity, py::arg("drive") = SceneDrive{},
          py::arg("friction") = 0.0, py::arg("damping") = 0.0, py::arg("holds") = true,
          "A joint between bodies, links and the ground (parent None), which may close loops. kind: 'fixed', "
          "'revolute', 'prismatic', 'ball'. Its value is 0 at the start. holds: False: from the action "
          "'join' on.")
      .def("add_latch_option", &add_latch_option, py::arg("carried"), py::arg("carrier"),
           py::arg("allowed") = std::vector<std::pair<std::string, std::string>>{},
           "A latch that Simulation.latch() may close; allowed: pairs of names that are not checked while it "
           "holds.")
      // Actions at a time.
      .def("act", &act, py::arg("time"), py::arg("kind"), py::arg("what"), py::arg("drive") = py::none(),
           py::arg("value") = py::none(), py::arg("rate") = py::none(), py::arg("carrier") = py::none(),
           py::arg("allowed") = std::vector<std::pair<std::string, std::string>>{},
           "From the first step on that starts at time [s] or later, what: a joint's name, of which kind "
           "'drive' sets the drive, 'set' value and rate (None: 0), 'join' has a joint between bodies hold "
           "as they then stand, 'part' lets go; or an object's, of which 'latch' has carrier carry it "
           "(allowed: pairs of names that are not checked meanwhile), 'release' ends that, 'add' and "
           "'remove' bring it and take it out.");
}

void bind_drives(py::module_& module) {
  py::class_<SceneDrive>(module, "JointDrive", "What drives a joint.")
      .def(py::init(&make_drive), py::arg("mode") = "torque", py::arg("torque") = 0.0, py::arg("rate") = 0.0,
           py::arg("limit") = kInfinity, py::arg("position") = 0.0, py::arg("stiffness") = 0.0,
           py::arg("damping") = 0.0, py::arg("ramp") = 0.0,
           "mode: 'torque', which grows by ramp a second; 'rate', 'brake', with at most limit; 'position': "
           "stiffness (position - value) + damping (rate - the joint's), cut to limit. [N m, rad] or [N, m].")
      .def_property_readonly(
          "mode",
          [](const SceneDrive& self) {
            for (const auto& [name, mode] : kDriveModes)
              if (mode == self.drive.mode) return std::string(name);
            return std::string();
          },
          "'torque', 'rate', 'brake' or 'position'.");
}

}  // namespace

std::vector<std::string> joint_names(const DynamicScene& self) {
  std::vector<std::string> made;
  for (std::size_t m = 0; m < self.mechanisms.size(); ++m)
    for (std::size_t j = 0; j < self.mechanisms[m].joints.size(); ++j) made.push_back(name_of(self, {m, j}));
  for (std::size_t j = 0; j < self.joints.size(); ++j)
    made.push_back(name_of(self, {JointAddress::kBodyJoint, j}));
  return made;
}

void bind_dynamic_scenes(py::module_& module) {
  bind_drives(module);
  // The scene: its bodies, names and settings.
  SceneClass scene(module, "DynamicScene", "Bodies, joints, actions and their laws; SI units.");
  scene
      .def(py::init(&make_scene), py::arg("name"), py::arg("duration"), py::arg("step") = 1e-3,
           py::arg("gravity") = py::make_tuple(0.0, 0.0, 0.0),
           "duration and step [s]; the step divides the duration. gravity: (3,) [m/s2].")
      .def("add", &add_body, py::arg("tree"), py::arg("X_WO") = py::none(), py::arg("kind") = "dynamic",
           py::arg("mass") = py::none(), py::arg("density") = py::none(), py::arg("velocity") = py::none(),
           py::arg("angular_velocity") = py::none(), py::arg("friction") = 0.5, py::arg("restitution") = 0.0,
           "Adds a body; returns its number. kind: 'static', 'dynamic', or 'link': moved by add_joint()'s. "
           "mass [kg] or density [kg/m3], uniform. velocity (3,) of the centre of mass [m/s], "
           "angular_velocity (3,) [rad/s].")
      .def_property_readonly(
          "name", [](const DynamicScene& self) { return self.scene.name; }, "As given.")
      .def_property_readonly("objects", &object_names, "Names of bodies and links, by their numbers.")
      .def_property_readonly("joints", &joint_names,
                             "Names of the joints, as Simulation.joint_value() takes them.")
      .def_property_readonly("step_count", &DynamicScene::step_count, "Steps of the whole duration.")
      .def_readonly("step", &DynamicScene::step, "Length of a step [s].")
      .def_readwrite("contact_margin", &DynamicScene::contact_margin,
                     "Points up to this far apart are found [m].")
      .def_readwrite("bounce_speed", &DynamicScene::bounce_speed, "Slower approaches do not bounce [m/s].")
      .def_readwrite("push_out", &DynamicScene::push_out,
                     "Rate at which overlap parts, times its depth [1/s]; 0: not at all.")
      .def_readwrite("sleep_speed", &DynamicScene::sleep_speed,
                     "Bodies slower than this [m/s] for sleep_time sleep.")
      .def_readwrite("sleep_time", &DynamicScene::sleep_time, "[s]; inf: nothing sleeps.")
      .def(
          "tree",
          [](const DynamicScene& self, std::size_t object) {
            if (object >= self.scene.objects.size())
              throw py::index_error("object " + std::to_string(object));
            return std::make_shared<HexahedronTree>(self.scene.objects[object].tree);
          },
          py::arg("object"), "The hexahedra of an object, by its number. Raises IndexError.");
  bind_joints(scene);
#ifdef TOUCHSTONE_HAS_DYNAMICS_FILES
  module.def(
      "load_dynamic_scene",
      [](const std::string& path, const std::map<std::string, double>& parameters) {
        return std::make_shared<DynamicScene>(load_dynamic_scene(path, parameters));
      },
      py::arg("path"), py::arg("parameters") = std::map<std::string, double>{},
      "Reads a scene file with dynamics (adapters/scene_files/README.md). parameters replace the file's "
      "own.");
#endif
}

}  // namespace touchstone::python
