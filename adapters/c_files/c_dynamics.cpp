#include <algorithm>
#include <cstring>

#include "touchstone/adapters/c_files/scene_parameters.hpp"
#include "touchstone/adapters/c_files/touchstone_dynamics.h"
#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"
#include "touchstone/physics/scene/joint_names.hpp"

// Runs of scene files' dynamics.

using namespace touchstone;
using namespace touchstone::physics;
using c_interface::guarded;
using c_interface::require;

struct touchstone_simulation {
  touchstone_simulation(DynamicScene of, const char* check) : scene(std::move(of)) {
    EngineRegistry engines;
    register_own_engine(engines, c_interface::registry());
    engine = engines.make({"own", check}, scene);
    for (std::size_t object = 0; object < scene.scene.objects.size(); ++object)
      object_of.insert(object_of.end(), scene.scene.objects[object].tree.solids().size(), object);
  }

  DynamicScene scene;
  std::unique_ptr<DynamicsEngine> engine;
  std::vector<std::size_t> object_of;  ///< by solid
  std::vector<EngineContact> found;    ///< of the last step, as what follows; kept for their room
  std::vector<touchstone_contact> contacts;
};

struct touchstone_saved_run {
  std::unique_ptr<EngineSnapshot> state;
};

namespace {

Vector3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }
void write(const Vector3& v, double* to) { std::copy_n(v.data(), 3, to); }

touchstone_object_state state_of(const DynamicsEngine& engine, std::size_t object) {
  touchstone_object_state state;
  const Pose X_WO = engine.object_pose(object);
  std::memcpy(&state.X_WO, &X_WO, sizeof X_WO);
  const Vector3 none = Vector3::Constant(kNaN);
  write(engine.velocity(object).value_or(none), state.v_W);
  write(engine.angular_velocity(object).value_or(none), state.w_W);
  return state;
}

}  // namespace

touchstone_code touchstone_load_simulation(const char* check, const char* path,
                                           const touchstone_parameter* parameters, size_t count,
                                           touchstone_simulation** out) {
  return guarded({{check, "check"}, {path, "path"}, {static_cast<const void*>(out), "out"}}, [&] {
    DynamicScene scene = load_dynamic_scene(path, c_interface::scene_parameters(parameters, count));
    *out = std::make_unique<touchstone_simulation>(std::move(scene), check).release();
  });
}

void touchstone_destroy_simulation(touchstone_simulation* simulation) { delete simulation; }

touchstone_code touchstone_get_simulation_facts(const touchstone_simulation* simulation,
                                                touchstone_simulation_facts* out) {
  return guarded({{simulation, "simulation"}, {out, "out"}}, [&] {
    const DynamicScene& scene = simulation->scene;
    *out = {scene.step, scene.step_count(), scene.scene.objects.size()};
  });
}

touchstone_code touchstone_find_simulated_object(const touchstone_simulation* simulation, const char* name,
                                                 size_t* out) {
  return guarded({{simulation, "simulation"}, {name, "name"}, {out, "out"}}, [&] {
    const auto& objects = simulation->scene.scene.objects;
    const auto found = std::find_if(objects.begin(), objects.end(),
                                    [&](const SceneObject& object) { return object.tree.name() == name; });
    if (found == objects.end()) reject(name, "is no object of the scene");
    *out = static_cast<std::size_t>(found - objects.begin());
  });
}

touchstone_code touchstone_step_simulation(touchstone_simulation* simulation, touchstone_step* out) {
  return guarded({{simulation, "simulation"}, {out, "out"}}, [&] {
    DynamicsEngine& engine = *simulation->engine;
    engine.begin_step();
    const EngineStep step = engine.step();
    if (!step.failure.empty())
      throw std::runtime_error("step " + std::to_string(engine.steps()) + ": " + step.failure);
    *out = {
        engine.steps(),     engine.time(), step.contacts, step.undecided, step.failed, step.unconverged, 0,
        step.worst_residual};
  });
}

touchstone_code touchstone_get_object_states(const touchstone_simulation* simulation,
                                             touchstone_object_state* states, size_t count) {
  return guarded({{simulation, "simulation"}}, [&] {
    if (count > 0) require(states, "states");
    const std::size_t objects = simulation->scene.scene.objects.size();
    if (count > objects)
      reject("count", std::to_string(count) + " is more than the scene's " + std::to_string(objects));
    for (std::size_t i = 0; i < count; ++i) states[i] = state_of(*simulation->engine, i);
  });
}

touchstone_code touchstone_get_contacts(touchstone_simulation* simulation, const touchstone_contact** out,
                                        size_t* count) {
  return guarded({{simulation, "simulation"}, {static_cast<const void*>(out), "out"}, {count, "count"}}, [&] {
    simulation->engine->list_contacts(simulation->found);
    simulation->contacts.clear();
    for (const EngineContact& of : simulation->found) {
      touchstone_contact& contact = simulation->contacts.emplace_back();
      contact.object_a = simulation->object_of[of.solids.a];
      contact.object_b = simulation->object_of[of.solids.b];
      write(of.p_W, contact.p_W);
      write(of.n_AB_W, contact.n_AB_W);
      contact.separation = of.separation;
      write(of.force_W, contact.force_W);
    }
    *out = simulation->contacts.data();
    *count = simulation->contacts.size();
  });
}

touchstone_code touchstone_get_joint_state(const touchstone_simulation* simulation, const char* joint,
                                           touchstone_joint_state* out) {
  return guarded({{simulation, "simulation"}, {joint, "joint"}, {out, "out"}}, [&] {
    const JointAddress address = joint_named(simulation->scene, joint);
    const DynamicsEngine& engine = *simulation->engine;
    *out = {engine.joint_value(address), engine.joint_rate(address), engine.joint_torque(address)};
  });
}

touchstone_code touchstone_push_object(touchstone_simulation* simulation, size_t object,
                                       const double force_W[3], const double p_W[3],
                                       const double moment_W[3]) {
  return guarded({{simulation, "simulation"}, {force_W, "force_W"}, {p_W, "p_W"}}, [&] {
    const Vector3 moment = moment_W == nullptr ? Vector3::Zero() : vector_of(moment_W);
    simulation->engine->push(object, vector_of(force_W), vector_of(p_W), moment);
  });
}

touchstone_code touchstone_save_run(const touchstone_simulation* simulation, touchstone_saved_run** out) {
  return guarded({{simulation, "simulation"}, {static_cast<const void*>(out), "out"}},
                 [&] { *out = new touchstone_saved_run{simulation->engine->snapshot()}; });
}

touchstone_code touchstone_restore_run(touchstone_simulation* simulation, const touchstone_saved_run* saved) {
  return guarded({{simulation, "simulation"}, {saved, "saved"}},
                 [&] { simulation->engine->restore(*saved->state); });
}

touchstone_code touchstone_reset_run(touchstone_simulation* simulation) {
  return guarded({{simulation, "simulation"}}, [&] { simulation->engine->reset(); });
}

void touchstone_destroy_saved_run(touchstone_saved_run* saved) { delete saved; }
