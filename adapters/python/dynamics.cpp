#include <pybind11/stl.h>

#include "touchstone/adapters/all/all_engines.hpp"
#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/adapters/python/dynamic_scenes.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/engine/engine_touches.hpp"
#include "touchstone/physics/scene/joint_names.hpp"

namespace touchstone::python {
namespace {

using namespace touchstone::physics;

const EngineRegistry& engines() {
  static const EngineRegistry* const registry = [] {
    auto made = std::make_unique<EngineRegistry>();
    register_all_engines(*made, backends());
    return made.release();
  }();
  return *registry;
}

// ---- runs

struct ContactRow {
  std::uint32_t solid_a, solid_b;
  PairStatus status;
  double separation;
  std::array<double, 3> p_W, n_AB_W, force_W, impact_W;
};

std::array<double, 3> array3(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

struct TouchRow {
  std::uint8_t kind;
  std::uint32_t solid_a, solid_b, points;
  std::array<double, 3> impulse_W, impact_W;
};

/// A run, its scene (a copy: Python's may go on changing), and whether a thread is in a step.
class Run {
 public:
  Run(const DynamicScene& scene, const std::string& engine) : scene_(scene) {
    validate(scene_);
    engine_ = engines().make(parse_engine_choice(engine), scene_);
  }

  DynamicsEngine& get() {
    if (is_busy_) throw std::runtime_error("simulation: is in use by another thread");
    return *engine_;
  }

  std::uint64_t advance(std::uint64_t steps) {
    DynamicsEngine& engine = get();
    std::uint64_t taken = 0;
    last_ = {};  // what a step failed for may have its place now
    {
      const Stepping stepping(*this);
      const py::gil_scoped_release unlocked;
      while (taken < steps && !engine.is_over() && last_.failure.empty()) {
        engine.begin_step();
        last_ = engine.step();
        if (!last_.failure.empty()) break;
        ++taken;
        if (touches_) take_touches();
      }
    }
    if (!last_.failure.empty())
      throw std::runtime_error("step " + std::to_string(engine.steps()) + ": " + last_.failure);
    return taken;
  }

  const EngineStep& last() const { return last_; }

  /// Goes back; what touched is forgotten, and so is a failure.
  template <class Back>
  void go_back(const Back& back) {
    back(get());
    last_ = {};
    if (touches_) touches_->forget();
  }

  void watch_touches(bool is_watched) {
    get();
    touches_.reset();
    if (is_watched) touches_.emplace(scene_.scene.contact_gap);
  }
  /// @throws InputError: nobody asked for them.
  const TouchEvents& touches() {
    get();
    if (!touches_) throw InputError("touches: watch_touches(True) comes first");
    return *touches_;
  }

  const DynamicScene& scene() const { return scene_; }
  std::size_t object(const std::string& name) const {
    const std::size_t found = find_object(scene_.scene, name);
    if (found == kNoObject) reject(name, "is no object of the scene");
    return found;
  }
  JointAddress joint(const std::string& name) const { return joint_named(scene_, name); }
  std::size_t object_count() const { return scene_.scene.objects.size(); }

 private:
  /// Of one thread, until its steps have ended, however that was. With Python's lock.
  class Stepping {
   public:
    explicit Stepping(Run& run) : run_(run) { run_.is_busy_ = true; }
    ~Stepping() { run_.is_busy_ = false; }
    Stepping(const Stepping&) = delete;
    Stepping& operator=(const Stepping&) = delete;

   private:
    Run& run_;
  };

  void take_touches() {
    engine_->list_contacts(listed_);
    physics::take_touches(*engine_, listed_, *touches_);
  }

  DynamicScene scene_;
  std::unique_ptr<DynamicsEngine> engine_;
  EngineStep last_;
  std::optional<TouchEvents> touches_;  // while they are watched
  std::vector<EngineContact> listed_;
  bool is_busy_ = false;
};

py::array poses_of(Run& self) {
  Doubles made({static_cast<py::ssize_t>(self.object_count()), py::ssize_t{4}, py::ssize_t{4}});
  for (std::size_t i = 0; i < self.object_count(); ++i)
    write_rows(self.get().object_pose(i), made.mutable_data() + 16 * i);
  return made;
}

/// NaN for what has none.
template <class Ask>
py::array velocities_of(Run& self, Ask ask) {
  Doubles made({static_cast<py::ssize_t>(self.object_count()), py::ssize_t{3}});
  const Vector3 nothing = Vector3::Constant(kNaN);
  for (std::size_t i = 0; i < self.object_count(); ++i) {
    const Vector3 v = ask(self.get(), i).value_or(nothing);
    std::copy_n(v.data(), 3, made.mutable_data() + 3 * i);
  }
  return made;
}

py::array contacts_of(Run& self) {
  std::vector<EngineContact> contacts;
  self.get().list_contacts(contacts);
  const py::dtype dtype = record_dtype({{"solid_a", "u4", offsetof(ContactRow, solid_a)},
                                        {"solid_b", "u4", offsetof(ContactRow, solid_b)},
                                        {"status", "u1", offsetof(ContactRow, status)},
                                        {"separation", "f8", offsetof(ContactRow, separation)},
                                        {"p_W", "(3,)f8", offsetof(ContactRow, p_W)},
                                        {"n_AB_W", "(3,)f8", offsetof(ContactRow, n_AB_W)},
                                        {"force_W", "(3,)f8", offsetof(ContactRow, force_W)},
                                        {"impact_W", "(3,)f8", offsetof(ContactRow, impact_W)}},
                                       sizeof(ContactRow));
  std::vector<ContactRow> rows;
  for (const EngineContact& of : contacts)
    rows.push_back({of.solids.a, of.solids.b, of.status, of.separation, array3(of.p_W), array3(of.n_AB_W),
                    array3(of.force_W), array3(of.impact_W)});
  return py::array(dtype, {static_cast<py::ssize_t>(rows.size())}, {}, rows.data());
}

py::array touches_of(Run& self) {
  const py::dtype dtype = record_dtype({{"kind", "u1", offsetof(TouchRow, kind)},
                                        {"solid_a", "u4", offsetof(TouchRow, solid_a)},
                                        {"solid_b", "u4", offsetof(TouchRow, solid_b)},
                                        {"points", "u4", offsetof(TouchRow, points)},
                                        {"impulse_W", "(3,)f8", offsetof(TouchRow, impulse_W)},
                                        {"impact_W", "(3,)f8", offsetof(TouchRow, impact_W)}},
                                       sizeof(TouchRow));
  std::vector<TouchRow> rows;
  for (const TouchEvent& of : self.touches().events())
    rows.push_back({static_cast<std::uint8_t>(of.kind), of.solids.a, of.solids.b,
                    static_cast<std::uint32_t>(of.points), array3(of.impulse_W), array3(of.impact_W)});
  return py::array(dtype, {static_cast<py::ssize_t>(rows.size())}, {}, rows.data());
}

// ---- commands

Vector3 vector_or(const py::object& given, const char* name, const Vector3& otherwise) {
  return given.is_none() ? otherwise : vector3(given, name);
}

void push(Run& self, const std::string& name, const py::object& force, const py::object& at,
          const py::object& moment) {
  const std::size_t object = self.object(name);
  self.get().push(object, vector_or(force, "force", Vector3::Zero()),
                  vector_or(at, "at", self.get().object_pose(object).p),
                  vector_or(moment, "moment", Vector3::Zero()));
}

/// The object comes to its initial pose, moving as at the start, where nothing else is said.
void add(Run& self, const std::string& name, const py::object& X_WO, const py::object& velocity,
         const py::object& angular_velocity) {
  const std::size_t object = self.object(name);
  const SceneBody& body = self.scene().bodies[object];
  self.get().add(object, X_WO.is_none() ? self.scene().scene.objects[object].X_WO : pose(X_WO, "X_WO"),
                 vector_or(velocity, "velocity", body.v_W),
                 vector_or(angular_velocity, "angular_velocity", body.w_W));
}

void act(Run& self, SceneAction::Kind kind, const std::string& joint, const SceneDrive& drive = {},
         double value = 0.0, double rate = 0.0) {
  SceneAction action;
  action.kind = kind;
  action.joint = self.joint(joint);
  action.drive = drive;
  action.value = value, action.rate = rate;
  self.get().act(action);
}

void latch(Run& self, const std::string& carried, const std::optional<std::string>& carrier) {
  SceneAction action;
  action.kind = carrier ? SceneAction::Kind::latch : SceneAction::Kind::release;
  action.carried = self.object(carried);
  if (carrier) action.carrier = self.object(*carrier);
  self.get().act(action);
}

py::dict last_step(const Run& self) {
  const EngineStep& of = self.last();
  py::dict made;
  made["contacts"] = of.contacts;
  made["undecided"] = of.undecided;
  made["failed"] = of.failed;
  made["unconverged"] = of.unconverged;
  made["worst_residual"] = of.worst_residual;
  made["total_us"] = of.total_us;
  made["detection_us"] = of.detection_us;
  return made;
}

void bind_commands(py::class_<Run>& run) {
  // Of bodies and links.
  run.def("push", &push, py::arg("object"), py::arg("force") = py::none(), py::arg("at") = py::none(),
          py::arg("moment") = py::none(),
          "Pushes a body or link over the next step alone: force (3,) [N] at a point of the world (3,) [m], "
          "None: the object's origin; moment (3,) [N m]. Several add up. Raises InputError for what no "
          "force moves and figures that are not finite.")
      .def(
          "remove", [](Run& self, const std::string& name) { self.get().remove(self.object(name)); },
          py::arg("object"), "Takes a free body out: it touches nothing and stays where it is.")
      .def("add", &add, py::arg("object"), py::arg("X_WO") = py::none(), py::arg("velocity") = py::none(),
           py::arg("angular_velocity") = py::none(),
           "Brings a free body of the scene in that is out. None: as at the scene's start. "
           "velocity (3,) of the centre of mass [m/s], angular_velocity (3,) [rad/s].")
      .def(
          "has", [](Run& self, const std::string& name) { return self.get().has(self.object(name)); },
          py::arg("object"), "Whether it is in the world.")
      .def(
          "latch",
          [](Run& self, const std::string& carried, const std::string& carrier) {
            latch(self, carried, carrier);
          },
          py::arg("carried"), py::arg("carrier"),
          "From now on the carrier carries it as it stands: an inelastic capture. What they allow: "
          "DynamicScene.add_latch_option(), which engines but 'own' need.")
      .def(
          "release", [](Run& self, const std::string& carried) { latch(self, carried, std::nullopt); },
          py::arg("carried"), "Ends its latch.")
      // Of joints.
      .def(
          "set_drive",
          [](Run& self, const std::string& name, const SceneDrive& drive) {
            act(self, SceneAction::Kind::drive, name, drive);
          },
          py::arg("joint"), py::arg("drive"), "Drives a joint from now on; ramps begin now.")
      .def(
          "set_joint",
          [](Run& self, const std::string& name, double value, double rate) {
            act(self, SceneAction::Kind::set_joint, name, {}, value, rate);
          },
          py::arg("joint"), py::arg("value"), py::arg("rate") = 0.0,
          "Puts a mechanism's joint at a value and rate, whatever is in the way.")
      .def(
          "join", [](Run& self, const std::string& name) { act(self, SceneAction::Kind::join, name); },
          py::arg("joint"), "A joint between bodies holds them from now on, as they stand.")
      .def(
          "part", [](Run& self, const std::string& name) { act(self, SceneAction::Kind::part, name); },
          py::arg("joint"), "It lets go.");
}

void bind_returns(py::module_& module, py::class_<Run>& run) {
  py::class_<EngineSnapshot, std::shared_ptr<EngineSnapshot>>(
      module, "Snapshot", "A simulation's state, for Simulation.restore() of the same one.");
  run.def(
         "snapshot", [](Run& self) { return std::shared_ptr<EngineSnapshot>(self.get().snapshot()); },
         "All that the run has come to. Raises InputError where the engine has no such means.")
      .def(
          "restore",
          [](Run& self, const std::shared_ptr<EngineSnapshot>& snapshot) {
            if (!snapshot) reject("snapshot", "is None");
            self.go_back([&](DynamicsEngine& of) { of.restore(*snapshot); });
          },
          py::arg("snapshot"),
          "Back to then. How steps compare with those that followed it: after_restore. Raises InputError: of "
          "another simulation.")
      .def(
          "reset", [](Run& self) { self.go_back([](DynamicsEngine& of) { of.reset(); }); },
          "Back to the start: the steps that follow are those of a new simulation, to the bit.")
      .def_property_readonly(
          "after_restore", [](Run& self) { return std::string(to_string(self.get().after_restore())); },
          "'same bits', 'repeatable' (the same after every restore of one snapshot), or '-'.")
      .def("watch_touches", &Run::watch_touches, py::arg("on") = true,
           "From the next step on touches has what begins to touch, goes on, or parts.")
      .def_property_readonly(
          "touches", &touches_of,
          "(k,) records of the last step: kind (0 began, 1 persisted, 2 ended), solid_a < solid_b, points, "
          "impulse_W on B over the step [N s], impact_W of it (NaN: not distinguished). What sleeps persists "
          "with 0 points and the impulse of its last step awake.");
}

void bind_state(py::class_<Run>& run) {
  // Time.
  run.def_property_readonly(
         "steps", [](Run& self) { return self.get().steps(); }, "Steps taken so far.")
      .def_property_readonly(
          "time", [](Run& self) { return self.get().time(); }, "[s]")
      .def_property_readonly(
          "is_over", [](Run& self) { return self.get().is_over(); },
          "Whether the scene's duration has passed.")
      // The objects.
      .def_property_readonly("poses", &poses_of, "(objects, 4, 4): X_WO.")
      .def_property_readonly(
          "velocities",
          [](Run& self) {
            return velocities_of(self,
                                 [](const DynamicsEngine& of, std::size_t i) { return of.velocity(i); });
          },
          "(objects, 3) of centres of mass [m/s]; NaN for what is not dynamic.")
      .def_property_readonly(
          "angular_velocities",
          [](Run& self) {
            return velocities_of(
                self, [](const DynamicsEngine& of, std::size_t i) { return of.angular_velocity(i); });
          },
          "(objects, 3) [rad/s]; NaN for what is not dynamic.")
      // The last step.
      .def_property_readonly(
          "contacts", &contacts_of,
          "(k,) records of the last step: solid_a, solid_b, status, separation [m], p_W, n_AB_W, "
          "force_W on B [N], impact_W [N s].")
      .def_property_readonly("last_step", &last_step, "Counts and times [us] of the last step.")
      // Sums over all objects.
      .def_property_readonly(
          "energy", [](Run& self) { return self.get().energy(); }, "[J]")
      .def_property_readonly(
          "linear_momentum", [](Run& self) { return frozen(array_of(self.get().linear_momentum())); },
          "(3,) of free bodies and mechanisms [N s].")
      .def_property_readonly(
          "angular_momentum", [](Run& self) { return frozen(array_of(self.get().angular_momentum())); },
          "(3,) of the same, about the world's origin [N m s].")
      .def_property_readonly(
          "worst_depth", [](Run& self) { return self.get().worst_depth(); }, "The deepest overlap now [m].")
      // Joints.
      .def(
          "joint_value",
          [](Run& self, const std::string& name) { return self.get().joint_value(self.joint(name)); },
          py::arg("name"), "Its value now [rad] or [m].")
      .def(
          "joint_rate",
          [](Run& self, const std::string& name) { return self.get().joint_rate(self.joint(name)); },
          py::arg("name"), "Its rate now [rad/s] or [m/s].")
      .def(
          "joint_torque",
          [](Run& self, const std::string& name) { return self.get().joint_torque(self.joint(name)); },
          py::arg("name"), "Mean of its drive over the last step [N m] or [N].");
}

}  // namespace

void bind_dynamics(py::module_& module) {
  bind_dynamic_scenes(module);
  module.def(
      "engines",
      [] {
        py::dict made;
        for (const EngineRegistry::Entry& entry : engines().engines())
          made[py::str(entry.name)] = py::make_tuple(entry.description, entry.checks);
        return made;
      },
      "Names of the engines of this build, each with its description and the checks that may stand inside.");
  py::class_<Run> run(module, "Simulation", "A scene stepped by an engine. One thread at a time.");
  run.def(py::init<const DynamicScene&, const std::string&>(), py::arg("scene"),
          py::arg("engine") = "own:native",
          "engine: 'bullet', 'own:native', 'ode:native'; see engines(). The scene is copied. Raises "
          "InputError where the engine lacks what the scene asks for.")
      .def("advance", &Run::advance, py::arg("steps") = 1,
           "Takes up to `steps` steps of the scene's, fewer at its end; returns how many. Raises "
           "RuntimeError with the name of what failed.");
  bind_commands(run);
  bind_returns(module, run);
  bind_state(run);
}

}  // namespace touchstone::python
