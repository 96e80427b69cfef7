#include "touchstone/adapters/python/world.hpp"

#include <pybind11/stl.h>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

/// Of an enumerator's name, as to_string() has it.
template <class Enum>
Enum named(const std::string& name, const char* what, std::initializer_list<Enum> all) {
  std::string known;
  for (const Enum value : all) {
    if (to_string(value) == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(to_string(value));
  }
  reject(what, "'" + name + "' is none of " + known);
}

ObjectHandle object_of(std::uint64_t number) {
  return {static_cast<std::uint32_t>(number & 0xffffffffU), static_cast<std::uint32_t>(number >> 32U)};
}

PairRule rule(const std::optional<std::string>& policy, std::optional<double> warn_distance,
              std::optional<bool> translation_only, const std::optional<std::string>& passive) {
  PairRule made;
  if (policy)
    made.policy =
        named(*policy, "policy",
              {ContactPolicy::cue, ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide});
  made.warn_distance = warn_distance;
  made.translation_only = translation_only;
  if (passive) made.passive = named(*passive, "passive", {Passive::stays, Passive::shoved, Passive::carried});
  return made;
}

std::vector<MotionCommand> commands_of(ContactWorld& world, const py::dict& poses, const py::dict& moves) {
  std::vector<MotionCommand> made;
  for (const auto& [object, X] : poses)
    made.push_back(world.go_to(object.cast<ObjectHandle>(), pose(X, "pose")));
  for (const auto& [object, move] : moves) {
    const auto parts = py::cast<py::sequence>(move);
    if (py::len(parts) != 2) reject("move", "is no (displacement, turn)");
    made.push_back(world.move_by(object.cast<ObjectHandle>(), vector3(parts[0], "displacement"),
                                 vector3(parts[1], "turn")));
  }
  return made;
}

std::unique_ptr<Report> frame(GuardedWorld& self, const py::dict& poses, const py::dict& moves,
                              const py::dict& joints) {
  ContactWorld& world = self.get();
  const std::vector<MotionCommand> commands = commands_of(world, poses, moves);
  std::vector<std::vector<double>> values;
  std::vector<JointCommand> joint_commands;
  for (const auto& [mechanism, q] : joints) {
    values.push_back(numbers(q, "joints"));
    joint_commands.push_back({mechanism.cast<MechanismHandle>(), {}});
  }
  for (std::size_t i = 0; i < values.size(); ++i) joint_commands[i].values = values[i];
  return self.without_lock(
      [&](ContactWorld& of) { return std::make_unique<Report>(kept(of.frame(commands, joint_commands))); });
}

SelectionChange change_of(bool on, const py::args& what) {
  if (what.empty()) return SelectionChange::of_everything(on);
  if (what.size() == 2)
    return SelectionChange::of(what[0].cast<ObjectHandle>(), what[1].cast<ObjectHandle>(), on);
  if (what.size() > 2)
    throw py::type_error("select: nothing, an object, two objects, a mechanism or a group");
  if (py::isinstance<py::str>(what[0])) return SelectionChange::of_group(what[0].cast<std::string>(), on);
  if (py::isinstance<MechanismHandle>(what[0]))
    return SelectionChange::of(what[0].cast<MechanismHandle>(), on);
  return SelectionChange::of(what[0].cast<ObjectHandle>(), on);
}

py::array poses_array(std::span<const Pose> poses) {
  Doubles made({static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* out = made.mutable_data();
  for (const Pose& X : poses) {
    write_rows(X, out);
    out += 16;
  }
  return made;
}

std::vector<PlacedHexahedron> placed_list(const py::iterable& solids) {
  std::vector<PlacedHexahedron> made;
  for (const py::handle& solid : solids) {
    const auto parts = py::cast<py::sequence>(solid);
    if (py::len(parts) != 3) throw py::type_error("solids: an entry is no (name, Hexahedron, pose)");
    made.push_back(
        {parts[0].cast<std::string>(), parts[1].cast<const Hexahedron&>(), pose(parts[2], "pose")});
  }
  return made;
}

// ---- mechanisms

void bind_parts(py::module_& module) {
  py::class_<LinkDescription>(module, "Link", "One rigid part of a mechanism.")
      // A link: its hexahedra and its mass.
      .def(py::init([](const std::string& name, const py::iterable& solids, double mass,
                       const py::object& centre, const py::object& inertia) {
             LinkDescription made{name, placed_list(solids), {}};
             made.mass.mass = mass;
             if (!centre.is_none()) made.mass.centre_L = vector3(centre, "centre");
             if (!inertia.is_none()) made.mass.inertia_L = matrix3(inertia, "inertia");
             made.mass.inertia_about_L = made.mass.centre_L;
             return made;
           }),
           py::arg("name"), py::arg("solids") = py::tuple(), py::arg("mass") = 0.0,
           py::arg("centre") = py::none(), py::arg("inertia") = py::none(),
           "solids: (name, Hexahedron, pose X_LS). mass [kg], centre (3,) of mass [m], inertia (3, 3) about "
           "it [kg m2].")
      .def_readonly("name", &LinkDescription::name, "As given.");
  // A joint: its frame, axis and limits.
  py::class_<JointDescription>(module, "Joint", "Joins a child link to its parent.")
      .def(py::init([](const std::string& name, const std::string& kind, const std::string& parent,
                       const std::string& child, const py::object& X_PJ, const py::object& axis, double lower,
                       double upper, double rate, double effort) {
             return JointDescription{
                 name,
                 named(kind, "kind", {JointKind::fixed, JointKind::revolute, JointKind::prismatic}),
                 parent,
                 child,
                 pose(X_PJ, "X_PJ"),
                 axis.is_none() ? Vector3(Vector3::UnitZ()) : vector3(axis, "axis"),
                 lower,
                 upper,
                 rate,
                 effort};
           }),
           py::arg("name"), py::arg("kind"), py::arg("parent"), py::arg("child"),
           py::arg("X_PJ") = py::none(), py::arg("axis") = py::none(), py::arg("lower") = -kInfinity,
           py::arg("upper") = kInfinity, py::arg("rate") = kInfinity, py::arg("effort") = kInfinity,
           "kind: 'fixed', 'revolute' [rad] or 'prismatic' [m]. X_PJ: the joint's frame in the parent; axis: "
           "(3,) unit, in it.")
      .def_readonly("name", &JointDescription::name, "As given.");
}

std::shared_ptr<Mechanism> make_mechanism(const std::string& name, std::vector<LinkDescription> links,
                                          std::vector<JointDescription> joints, const std::string& base,
                                          std::vector<double> reference,
                                          const std::vector<std::pair<std::string, std::string>>& exempt) {
  MechanismDescription made{name, std::move(links), std::move(joints), base, std::move(reference), {}, {}};
  for (const auto& [first, second] : exempt) made.exempt_pairs.push_back({first, second});
  return std::make_shared<Mechanism>(std::move(made));
}

void bind_mechanism(py::module_& module) {
  bind_parts(module);
  py::class_<Mechanism, std::shared_ptr<Mechanism>>(module, "Mechanism",
                                                    "A tree of links and joints, held by its base.")
      // Making.
      .def(py::init(&make_mechanism), py::arg("name"), py::arg("links"), py::arg("joints"),
           py::arg("base") = "", py::arg("reference") = std::vector<double>{},
           py::arg("exempt") = std::vector<std::pair<std::string, std::string>>{},
           "base: the link that is held; the first, if empty. reference: a value a joint that moves. exempt: "
           "pairs of links, or 'link/hexahedron', that are not checked.")
      // Names and the reference.
      .def_property_readonly("name", &Mechanism::name, "As given.")
      .def_property_readonly(
          "links",
          [](const Mechanism& self) {
            std::vector<std::string> made;
            for (const Mechanism::Link& link : self.links()) made.push_back(link.name);
            return made;
          },
          "Names, in the order of link_poses().")
      .def_property_readonly(
          "joints",
          [](const Mechanism& self) {
            std::vector<std::string> made;
            for (const Mechanism::Joint& joint : self.joints())
              if (joint.value != Mechanism::kNone) made.push_back(joint.name);
            return made;
          },
          "Names of the joints that move, in the order of joint values.")
      .def_property_readonly(
          "reference", [](const Mechanism& self) { return frozen(array_of(self.reference())); },
          "(n,) joint values [rad] or [m]. Not writeable.")
      // Kinematics.
      .def(
          "with_base",
          [](const Mechanism& self, const std::string& link) {
            return std::make_shared<Mechanism>(self.with_base(link));
          },
          py::arg("link"), "The same held by another link.")
      .def(
          "link_poses",
          [](const Mechanism& self, const py::object& q, const py::object& X_WB) {
            const std::vector<double> values = numbers(q, "q");
            if (values.size() != self.value_count())
              reject(self.name(), "has " + std::to_string(self.value_count()) + " joint values, not " +
                                      std::to_string(values.size()));
            std::vector<Pose> made(self.links().size());
            self.link_poses(rigid_frame(pose(X_WB, "X_WB")), values, made);
            return poses_array(made);
          },
          py::arg("q"), py::arg("X_WB") = py::none(),
          "(links, 4, 4): X_WL of every link at joint values q (n,).");
}

// ---- worlds

void bind_handles(py::module_& module) {
  py::class_<ObjectHandle>(module, "Object", "Names an object for as long as it lives; never reused.")
      .def(py::init(&object_of), py::arg("number"), "Of an event's field a or b.")
      .def("__int__", &number_of)
      .def("__hash__", &number_of)
      .def("__eq__", [](ObjectHandle a, const py::object& b) {
        return py::isinstance<ObjectHandle>(b) && a == b.cast<ObjectHandle>();
      });
  py::class_<MechanismHandle>(module, "MechanismHandle", "Names a mechanism for as long as it lives.")
      .def("__hash__",
           [](MechanismHandle m) { return static_cast<std::uint64_t>(m.generation) << 32U | m.index; })
      .def("__eq__", [](MechanismHandle a, const py::object& b) {
        return py::isinstance<MechanismHandle>(b) && a == b.cast<MechanismHandle>();
      });
}

void bind_objects(WorldClass& world) {
  world
      .def(
          "add",
          [](GuardedWorld& self, std::shared_ptr<HexahedronTree> tree, const py::object& X_WO, bool is_static,
             std::vector<std::string> groups, const std::vector<std::shared_ptr<HexahedronTree>>& levels) {
            return self.get().add({std::move(tree),
                                   pose(X_WO, "X_WO"),
                                   is_static,
                                   std::move(groups),
                                   {levels.begin(), levels.end()}});
          },
          py::arg("tree"), py::arg("X_WO") = py::none(), py::arg("is_static") = false,
          py::arg("groups") = std::vector<std::string>{},
          py::arg("levels") = std::vector<std::shared_ptr<HexahedronTree>>{},
          "Adds an object; X_WO: None, (4, 4), or (position, quaternion wxyz). Its name is the tree's. "
          "levels: coarser and coarser trees of it, each hexahedron inside one of the next; for speed alone.")
      // Which there are.
      .def(
          "remove", [](GuardedWorld& self, ObjectHandle object) { self.get().remove(object); },
          py::arg("object"),
          "Its rules and exemptions end with it. Raises InputError while it carries or is carried.")
      .def(
          "find", [](GuardedWorld& self, const std::string& name) { return self.get().find(name); },
          py::arg("name"),
          "The object of this name; of a link: 'mechanism.link'. Raises InputError where there is none.")
      .def(
          "is_alive", [](GuardedWorld& self, ObjectHandle object) { return self.get().is_alive(object); },
          py::arg("object"), "False once it was removed.")
      .def(
          "name_of",
          [](GuardedWorld& self, ObjectHandle object) { return std::string(self.get().name_of(object)); },
          py::arg("object"), "Of a link: 'mechanism.link'.")
      // Where they are.
      .def(
          "pose",
          [](GuardedWorld& self, ObjectHandle object) { return array_of(self.get().actual_pose(object)); },
          "(4, 4): X_WO as the last frame left it.")
      .def(
          "commanded_pose",
          [](GuardedWorld& self, ObjectHandle object) { return array_of(self.get().commanded_pose(object)); },
          py::arg("object"), "(4, 4): X_WO as last commanded.")
      .def(
          "solid_poses",
          [](GuardedWorld& self, ObjectHandle object) { return poses_array(self.get().solid_poses(object)); },
          "(n, 4, 4): X_WS of its hexahedra; (0, 4, 4) between set-up and prepare() or frame().")
      // Where they were within the last frame.
      .def(
          "executed_parts", [](GuardedWorld& self) { return self.get().executed_parts(); },
          "Parts of the last frame: 0 the commanded paths, then a sub-step of slides each.")
      .def(
          "executed_pose",
          [](GuardedWorld& self, ObjectHandle object, std::size_t part, double s) {
            if (part >= self.get().executed_parts() || !(s >= 0.0 && s <= 1.0))
              reject("executed_pose", "part " + std::to_string(part) + " at s = " + figure(s) + " is none");
            return array_of(self.get().executed_pose(object, part, s));
          },
          py::arg("object"), py::arg("part"), py::arg("s"), "(4, 4): X_WO at s of a part of the last frame.");
}

void bind_mechanisms_of(WorldClass& world) {
  world
      .def(
          "add_mechanism",
          [](GuardedWorld& self, std::shared_ptr<Mechanism> mechanism, const py::object& X_WB,
             std::vector<double> initial, std::vector<std::string> groups, std::vector<double> weights) {
            return self.get().add_mechanism({std::move(mechanism), pose(X_WB, "X_WB"), std::move(initial),
                                             std::move(groups), std::move(weights)});
          },
          py::arg("mechanism"), py::arg("X_WB") = py::none(), py::arg("initial") = std::vector<double>{},
          py::arg("groups") = std::vector<std::string>{}, py::arg("weights") = std::vector<double>{},
          "Adds a mechanism held at X_WB; its links are objects named 'mechanism.link'.")
      // Which there are.
      .def(
          "remove_mechanism", [](GuardedWorld& self, MechanismHandle of) { self.get().remove_mechanism(of); },
          py::arg("mechanism"), "And its links. Raises InputError while one carries an object.")
      .def(
          "link",
          [](GuardedWorld& self, MechanismHandle of, const std::string& name) {
            return self.get().link(of, name);
          },
          py::arg("mechanism"), py::arg("name"),
          "One of its links, as an object. Raises InputError for an unknown name.")
      // Where they are.
      .def(
          "joint_values",
          [](GuardedWorld& self, MechanismHandle of) { return array_of(self.get().joint_values(of)); },
          "(n,): as the last frame left them [rad] or [m].")
      .def(
          "commanded_joints",
          [](GuardedWorld& self, MechanismHandle of) { return array_of(self.get().commanded_joints(of)); },
          py::arg("mechanism"), "(n,): joint values as last commanded [rad] or [m].")
      .def(
          "link_poses",
          [](GuardedWorld& self, MechanismHandle of) { return poses_array(self.get().link_poses(of)); },
          "(links, 4, 4).");
}

void bind_rules(WorldClass& world) {
  const py::none none;
  world
      // Set for all, for two groups, for two objects; the narrower one goes first.
      .def(
          "set_default_rule",
          [](GuardedWorld& self, const std::optional<std::string>& policy,
             std::optional<double> warn_distance, std::optional<bool> translation_only,
             const std::optional<std::string>& passive) {
            self.get().set_default_rule(rule(policy, warn_distance, translation_only, passive));
          },
          py::arg("policy") = none, py::arg("warn_distance") = none, py::arg("translation_only") = none,
          py::arg("passive") = none,
          "policy: 'cue', 'hold', 'advance' or 'slide'; warn_distance [m]; passive: 'stays', 'shoved' or "
          "'carried'. None: inherited.")
      .def(
          "set_group_rule",
          [](GuardedWorld& self, const std::string& first, const std::string& second,
             const std::optional<std::string>& policy, std::optional<double> warn_distance,
             std::optional<bool> translation_only, const std::optional<std::string>& passive) {
            self.get().set_group_rule(first, second, rule(policy, warn_distance, translation_only, passive));
          },
          py::arg("first"), py::arg("second"), py::arg("policy") = none, py::arg("warn_distance") = none,
          py::arg("translation_only") = none, py::arg("passive") = none,
          "As set_default_rule(), of objects of two groups; the last given counts.")
      .def(
          "set_pair_rule",
          [](GuardedWorld& self, ObjectHandle a, ObjectHandle b, const std::optional<std::string>& policy,
             std::optional<double> warn_distance, std::optional<bool> translation_only,
             const std::optional<std::string>& passive) {
            self.get().set_pair_rule(a, b, rule(policy, warn_distance, translation_only, passive));
          },
          py::arg("a"), py::arg("b"), py::arg("policy") = none, py::arg("warn_distance") = none,
          py::arg("translation_only") = none, py::arg("passive") = none,
          "As set_default_rule(), of two objects, before those of their groups.")
      // The rule that two objects follow.
      .def(
          "rule_of",
          [](GuardedWorld& self, ObjectHandle a, ObjectHandle b) {
            const EffectiveRule of = self.get().rule_of(a, b);
            py::dict made;
            made["policy"] = std::string(to_string(of.policy));
            made["warn_distance"] = of.warn_distance;
            made["translation_only"] = of.translation_only;
            made["passive"] = std::string(to_string(of.passive));
            return made;
          },
          "What two objects follow.");
}

Exemption exemption(ObjectHandle a, ObjectHandle b, const std::string& solid_a, const std::string& solid_b) {
  return {a, b, solid_a, solid_b};
}

void bind_pairs_of(WorldClass& world) {
  world
      // Pairs that are not checked.
      .def(
          "exempt",
          [](GuardedWorld& self, ObjectHandle a, ObjectHandle b, const std::string& solid_a,
             const std::string& solid_b) { self.get().exempt(exemption(a, b, solid_a, solid_b)); },
          py::arg("a"), py::arg("b"), py::arg("solid_a") = "", py::arg("solid_b") = "",
          "Two objects, or hexahedra of them, are not checked until unexempt().")
      .def(
          "unexempt",
          [](GuardedWorld& self, ObjectHandle a, ObjectHandle b, const std::string& solid_a,
             const std::string& solid_b) { self.get().unexempt(exemption(a, b, solid_a, solid_b)); },
          py::arg("a"), py::arg("b"), py::arg("solid_a") = "", py::arg("solid_b") = "",
          "Takes back the same exempt().")
      // Objects that move as one.
      .def(
          "latch",
          [](GuardedWorld& self, ObjectHandle carrier, ObjectHandle carried,
             const std::vector<std::pair<ObjectHandle, ObjectHandle>>& allowed) {
            std::vector<Exemption> pairs;
            for (const auto& [a, b] : allowed) pairs.push_back({a, b});
            self.get().latch(carrier, carried, pairs);
          },
          py::arg("carrier"), py::arg("carried"),
          py::arg("allowed") = std::vector<std::pair<ObjectHandle, ObjectHandle>>{},
          "`carried` moves with `carrier` from now on; `allowed` pairs of objects are not checked meanwhile.")
      .def(
          "unlatch", [](GuardedWorld& self, ObjectHandle carried) { self.get().unlatch(carried); },
          py::arg("carried"), "Its latch ends, with the pairs that it allowed.")
      // The selection of pairs that are checked.
      .def(
          "select",
          [](GuardedWorld& self, bool on, const py::args& what) {
            self.unguarded().select(change_of(on, what));
          },
          "select(on): everything; select(on, object), (on, a, b), (on, mechanism) or (on, 'group'). From "
          "any thread; in force from the next frame on.");
}

/// The world of a Python object; null while that is made, when the collector may see it without a layout.
GuardedWorld* world_in(PyObject* self) {
  auto* const instance = reinterpret_cast<py::detail::instance*>(self);
  if (!instance->simple_layout || !instance->simple_holder_constructed) return nullptr;
  return instance->get_value_and_holder().value_ptr<GuardedWorld>();
}

/// Has Python's collector end worlds that are held by the executor that they borrow.
void collect_cycles(PyHeapTypeObject* made) {
  PyTypeObject& type = made->ht_type;
  type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    GuardedWorld* const world = world_in(self);
    return world == nullptr ? 0 : world->traverse(visit, arg);
  };
  type.tp_clear = [](PyObject* self) {
    if (GuardedWorld* const world = world_in(self)) world->clear();
    return 0;
  };
  // Objects released by the world's end may start the collector, which must no longer see the world.
  type.tp_dealloc = [](PyObject* self) {
    PyObject_GC_UnTrack(self);
    py::detail::pybind11_object_dealloc(self);
  };
}

}  // namespace

void bind_world(py::module_& module) {
  bind_mechanism(module);
  bind_handles(module);
  bind_report(module);
  bind_hands(module);
  WorldClass world(
      module, "World",
      "Objects and mechanisms, moved frame by frame as far as no pair gets closer than the gap allows. "
      "One thread at a time: a second one gets RuntimeError, but for select().",
      py::custom_type_setup(&collect_cycles));
  world
      .def(py::init<const std::string&, const std::string&, double>(), py::arg("narrowphase") = "native",
           py::arg("broadphase") = "native", py::arg("gap") = kDefaultGap, "gap: kept between objects [m].")
      // Frames, and what comes before them.
      .def("frame", &frame, py::arg("poses") = py::dict(), py::arg("moves") = py::dict(),
           py::arg("joints") = py::dict(),
           "One frame. poses: {object: pose X_WO to go to}; moves: {object: (displacement_W (3,) [m], turn_W "
           "(3,) axis times angle [rad])}; joints: {mechanism: values (n,)}. Returns a FrameReport.")
      .def(
          "prepare", [](GuardedWorld& self) { self.without_lock([](ContactWorld& of) { of.prepare(); }); },
          "Takes up all set-up so far.")
      .def(
          "reset", [](GuardedWorld& self) { self.get().reset(); },
          "Initial poses, no latches, everything selected.")
      .def_property_readonly(
          "gap", [](GuardedWorld& self) { return self.get().gap(); }, "Kept between objects [m].");
  // Its parts.
  bind_objects(world);
  bind_mechanisms_of(world);
  bind_rules(world);
  bind_pairs_of(world);
  bind_hands_of(world);
}

}  // namespace touchstone::python
