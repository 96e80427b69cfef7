#include <memory>
#include <string>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/physics/scene/scene_simulation.hpp"
#include "touchstone/tests/proof/hash/bit_sink.hpp"
#include "touchstone/tests/proof/hash/run_hash.hpp"

namespace touchstone::proof {
namespace {

using namespace physics;

constexpr double kStep = 2e-3;
const Vector3 kAtRest = Vector3::Zero();

Pose placed(const Vector3& p_W, const Vector3& turn = Vector3::Zero()) {
  Pose X;
  X.p = p_W;
  const double angle = norm(turn);
  if (angle > 0.0) X.R = rotation_about(turn / angle, angle);
  return X;
}

void add_box(DynamicScene& scene, const std::string& name, const Vector3& size, const Pose& X_WO,
             const SceneBody& body) {
  scene.scene.objects.push_back(
      {HexahedronTree({{"box", Hexahedron::from_size(size), {}}}, name), X_WO, {}, {}});
  scene.bodies.push_back(body);
}

SceneBody free_box(const Vector3& size, const Vector3& v_W, const Vector3& w_W) {
  return {
      BodyKind::dynamic, box_inertia(1000.0 * size.x() * size.y() * size.z(), size), v_W, w_W, {0.5, 0.1}};
}

DynamicScene on_a_slab(std::size_t steps) {
  DynamicScene scene;
  scene.scene.name = "run";
  scene.scene.frame_rate = 50.0;
  scene.scene.contact_gap = 1e-9;
  scene.scene.duration = kStep * static_cast<double>(steps);
  scene.gravity_W = {0.0, 0.0, -9.81};
  scene.step = kStep;
  add_box(scene, "slab", {20, 20, 1}, placed({0, 0, -0.5}), {});
  return scene;
}

/// Every bit that the simulation shows after a step.
void put_state(const SceneSimulation& run, BitSink& sink) {
  for (std::size_t i = 0; i < run.scene().bodies.size(); ++i) {
    sink.put(run.object_pose(i));
    if (run.velocity(i)) sink.put(*run.velocity(i)), sink.put(*run.angular_velocity(i));
  }
  for (std::size_t m = 0; m < run.scene().mechanisms.size(); ++m)
    for (std::size_t j = 0; j < run.scene().mechanisms[m].joints.size(); ++j)
      sink.put(run.joint_value({m, j})), sink.put(run.joint_rate({m, j})), sink.put(run.joint_torque({m, j}));
  for (const Contact& contact : run.contacts())
    sink.put(contact.n_AB_W), sink.put(contact.p_A_W), sink.put(contact.p_B_W);
  for (const ContactForce& force : run.forces()) sink.put(force.force_W), sink.put(force.impact_W);
}

std::uint64_t hash_of(const DynamicScene& scene) {
  SceneSimulation run(scene, [] {
    return std::make_unique<NarrowphaseContacts>(make_native_broadphase(), make_native(), 1e-3);
  });
  BitSink sink;
  while (!run.is_over()) {
    run.begin_step();
    run.find_contacts();
    const StepReport report = run.advance();
    sink.put(static_cast<std::uint64_t>(report.failure));
    if (report.failure != StepFailure::none) break;
    put_state(run, sink);
  }
  return sink.value();
}

DynamicScene stack(std::size_t steps) {
  DynamicScene scene = on_a_slab(steps);
  const Vector3 size(0.3, 0.25, 0.2);
  for (int i = 0; i < 5; ++i)
    add_box(scene, "box " + std::to_string(i), size,
            placed({0.03 * i, 0.0, 0.1 + 0.201 * i}, {0.0, 0.0, 0.3 * i}), free_box(size, kAtRest, kAtRest));
  return scene;
}

DynamicScene sliding(std::size_t steps) {
  DynamicScene scene = on_a_slab(steps);
  for (int i = 0; i < 4; ++i) {
    const Vector3 size(0.3 + 0.05 * i, 0.2, 0.1 + 0.05 * i);
    add_box(scene, "block " + std::to_string(i), size,
            placed({-2.0, 1.0 * i, 0.5 * size.z() + 0.01 * i}, {0.0, 0.05 * i, 0.7 * i}),
            free_box(size, {1.5 + 0.3 * i, -0.4, 0.0}, {0.1 * i, 0.0, 2.0}));
  }
  return scene;
}

SceneJoint turning(const std::string& name, std::size_t parent, std::size_t child, const Vector3& p_W,
                   double rate) {
  SceneJoint joint;
  joint.name = name;
  joint.parent = parent;
  joint.child = child;
  joint.p_W = p_W;
  joint.drive.drive = {JointDrive::Mode::rate, 0.0, rate, 200.0};
  return joint;
}

/// Two driven links push a block over the slab; a tool that follows its motion turns by; a box in the air is
/// taken by the second link and let go.
DynamicScene pushing(std::size_t steps) {
  DynamicScene scene = on_a_slab(steps);
  // An arm of two links.
  const auto link = [](double mass, const Vector3& size) {
    return SceneBody{BodyKind::link, box_inertia(mass, size), kAtRest, kAtRest, {0.4, 0.0}};
  };
  add_box(scene, "upper", {1.0, 0.1, 0.1}, placed({0.5, 0, 0.2}), link(5.0, {1.0, 0.1, 0.1}));
  add_box(scene, "lower", {0.8, 0.1, 0.1}, placed({1.4, 0, 0.2}), link(3.0, {0.8, 0.1, 0.1}));
  scene.mechanisms.push_back(
      {"arm",
       {turning("shoulder", kNoObject, 1, {0, 0, 0.2}, 0.6), turning("elbow", 1, 2, {1.0, 0, 0.2}, 0.4)}});
  // A block that it pushes, a load that lies on it, and a tool that comes.
  const Vector3 size(0.3, 0.3, 0.3);
  add_box(scene, "block", size, placed({1.5, 0.3, 0.15}, {0, 0, 0.2}), free_box(size, kAtRest, kAtRest));
  add_box(scene, "load", {0.1, 0.1, 0.1}, placed({1.4, 0, 0.32}, {0.2, 0.1, 0}),
          free_box({0.1, 0.1, 0.1}, kAtRest, kAtRest));
  SceneBody tool;
  tool.kind = BodyKind::kinematic;
  add_box(scene, "tool", {0.2, 0.2, 0.2}, placed({-1.0, 0.5, 0.3}), tool);
  scene.scene.objects.back().motion.segments.push_back(
      {0.0, 100.0, {0.2, 0, 0}, Vector3(0.6, 0, 0.8), 0.9, {-1.0, 0.6, 0.3}});
  // The load is latched for half of the run.
  SceneAction latch, release;
  latch.kind = SceneAction::Kind::latch;
  latch.carrier = 2, latch.carried = 4;
  release.kind = SceneAction::Kind::release;
  release.time = 0.5 * scene.scene.duration, release.carried = 4;
  scene.actions = {latch, release};
  return scene;
}

}  // namespace

std::vector<FamilyHash> dynamics_hashes(std::size_t steps) {
  return {{"dynamics: stack", hash_of(stack(steps))},
          {"dynamics: blocks sliding to rest", hash_of(sliding(steps))},
          {"dynamics: arm pushing and carrying", hash_of(pushing(steps))}};
}

}  // namespace touchstone::proof
