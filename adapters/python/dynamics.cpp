#include <pybind11/stl.h>

#include "touchstone/adapters/all/all_engines.hpp"
#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/adapters/python/dynamic_scenes.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
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
    is_busy_ = true;
    std::uint64_t taken = 0;
    {
      const py::gil_scoped_release unlocked;
      while (taken < steps && !engine.is_over() && last_.failure.empty()) {
        engine.begin_step();
        last_ = engine.step();
        if (last_.failure.empty()) ++taken;
      }
    }
    is_busy_ = false;
    if (!last_.failure.empty())
      throw std::runtime_error("step " + std::to_string(engine.steps()) + ": " + last_.failure);
    return taken;
  }

  const EngineStep& last() const { return last_; }
  JointAddress joint(const std::string& name) const { return joint_named(scene_, name); }
  std::size_t object_count() const { return scene_.scene.objects.size(); }

 private:
  DynamicScene scene_;
  std::unique_ptr<DynamicsEngine> engine_;
  EngineStep last_;
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
  bind_state(run);
}

}  // namespace touchstone::python
