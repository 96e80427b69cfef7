#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"
#include "touchstone/tests/support/at.hpp"

// Dynamic scenes made by hand, and their steps.

namespace touchstone::physics {

inline const Vector3 kZero = Vector3::Zero();

inline SceneObject box(const std::string& name, const Vector3& size, const Pose& X_WO) {
  return {HexahedronTree({{"box", Hexahedron::from_size(size), {}}}, name), X_WO, {}, {}};
}

inline SceneBody free_body(double mass, const Vector3& size, const Vector3& v_W = kZero,
                           const Vector3& w_W = kZero) {
  return {BodyKind::dynamic, box_inertia(mass, size), v_W, w_W, {0.0, 0.0}, {}};
}

inline DynamicScene empty_scene(double duration) {
  DynamicScene out;
  out.scene.name = "scene";
  out.scene.frame_rate = 50;
  out.scene.contact_gap = 1e-9;
  out.scene.duration = duration;
  return out;
}

inline void add(DynamicScene& scene, const SceneObject& object, const SceneBody& body) {
  scene.scene.objects.push_back(object);
  scene.bodies.push_back(body);
}

inline std::unique_ptr<NarrowphaseContacts> native_contacts() {
  BackendRegistry registry;
  register_core(registry);
  return std::make_unique<NarrowphaseContacts>(registry.make_broadphase("native"),
                                               registry.make_narrowphase("native"), 1e-3);
}

inline StepReport step(SceneSimulation& simulation) {
  simulation.begin_step();
  simulation.find_contacts();
  return simulation.advance();
}

/// To the end, or to the first step that fails.
inline StepReport run_until_failure(SceneSimulation& simulation) {
  StepReport report;
  while (!simulation.is_over() && report.failure == StepFailure::none) report = step(simulation);
  return report;
}

inline void run(SceneSimulation& simulation) {
  ASSERT_EQ(run_until_failure(simulation).failure, StepFailure::none);
}

inline SceneJoint pivot(std::size_t child, const Vector3& p_W) {
  SceneJoint joint;
  joint.name = "pivot";
  joint.child = child;
  joint.p_W = p_W;
  return joint;
}

}  // namespace touchstone::physics
