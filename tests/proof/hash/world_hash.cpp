#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/trigonometry.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/tests/proof/hash/bit_sink.hpp"
#include "touchstone/tests/proof/hash/run_hash.hpp"

namespace touchstone::proof {
namespace {

using measures::Random;

Pose random_pose(Random& random, double reach) {
  Pose X;
  X.R = measures::random_rotation(random);
  X.p = measures::uniform_vector(random, -reach, reach);
  return X;
}

void put_report(const FrameReport& report, BitSink& sink) {
  for (const ContactEvent& event : report.events) {
    sink.put(static_cast<std::uint64_t>(event.kind));
    sink.put(std::uint64_t{event.solids.a} << 32 | event.solids.b);
    sink.put(event.s);
    sink.put(event.geometry.separation);
    sink.put(event.geometry.n_AB_W);
    sink.put(event.geometry.p_A_W);
    sink.put(event.geometry.p_B_W);
  }
  for (const std::uint64_t count : {std::uint64_t{report.blocked_movers}, std::uint64_t{report.slide_steps},
                                    std::uint64_t{report.candidate_pairs}, report.queries})
    sink.put(count);
}

SceneObject tumbling_box(const std::string& name, Random& random) {
  const Hexahedron solid = Hexahedron::from_size(measures::uniform_vector(random, 0.4, 1.2));
  return {HexahedronTree({{"box", solid, {}}}, name), random_pose(random, 3.0), {}, {}};
}

/// Boxes around the origin that all go through the middle and turn on the way, by segments or by keys, among
/// two that stand; the first one carries the second.
Scene crowd(ContactPolicy policy) {
  Random random(7);
  Scene scene;
  scene.name = "crowd";
  scene.frame_rate = 25.0;
  scene.contact_gap = 1e-6;
  scene.duration = 40.0;
  scene.policy = policy;
  for (int i = 0; i < 12; ++i) {
    const std::string name = "box " + std::to_string(i);
    scene.objects.push_back(tumbling_box(name, random));
    SceneObject& object = scene.objects.back();
    if (i == 1 || i > 9) continue;
    if (i % 2 == 0) {
      const Vector3 axis = measures::random_direction(random);
      object.motion.segments.push_back(
          {0.0, 40.0, -0.4 * object.X_WO.p, axis / norm(axis), random.uniform(-2, 2), object.X_WO.p});
    } else {
      for (int k = 1; k <= 8; ++k) object.motion.keys.push_back({0.7 * k, random_pose(random, 1.5)});
    }
  }
  scene.latches.push_back({"box 0", "box 1", {}});
  return scene;
}

std::uint64_t crowd_hash(ContactPolicy policy, std::size_t frames) {
  const Scene scene = crowd(policy);
  SceneWorld flown(scene, make_native(), make_native_broadphase());
  BitSink sink;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    put_report(flown.step(), sink);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      sink.put(flown.world().actual_pose(flown.object(i)));
  }
  return sink.value();
}

/// The arm, base at the origin, with blocks in its reach.
struct ArmAmongBlocks {
  std::shared_ptr<const Mechanism> mechanism = std::make_shared<const Mechanism>(make_ssrms());
  ContactWorld world{make_native(), make_native_broadphase(), 1e-6};
  MechanismHandle arm;

  ArmAmongBlocks() {
    PairRule rule;
    rule.policy = ContactPolicy::slide;
    world.set_default_rule(rule);
    arm = world.add_mechanism({mechanism, {}, {0.1, 0.4, -0.8, 1.2, 0.5, -0.3, 0.2}});
    Random random(11);
    const Pose X_WT = world.link_poses(arm)[mechanism->find_link("tip")];
    for (int i = 0; i < 6; ++i) {
      Pose X = random_pose(random, 2.0);
      X.p += X_WT.p;
      if (norm(X.p - X_WT.p) < 1.5) X.p += 3.0 * Vector3::UnitZ();
      const Hexahedron solid = Hexahedron::from_size(measures::uniform_vector(random, 0.5, 1.0));
      const std::string name = "block " + std::to_string(i);
      world.add({std::make_shared<HexahedronTree>(std::vector<PlacedHexahedron>{{"block", solid, {}}}, name),
                 X, true});
    }
  }

  void move(std::span<const double> joints, BitSink& sink) {
    const JointCommand command{arm, joints};
    put_report(world.frame({}, {&command, 1}), sink);
    sink.put(world.joint_values(arm));
    for (const Pose& X : world.link_poses(arm)) sink.put(X);
  }
};

std::uint64_t swaying_arm_hash(std::size_t frames) {
  ArmAmongBlocks scene;
  const auto initial = scene.world.joint_values(scene.arm);
  const std::vector<double> start(initial.begin(), initial.end());
  BitSink sink;
  std::vector<double> goal(start.size());
  for (std::size_t frame = 1; frame <= frames; ++frame) {
    for (std::size_t k = 0; k < goal.size(); ++k)
      goal[k] = start[k] + 0.25 * sine(0.02 * static_cast<double>((k + 1) * frame));
    scene.move(goal, sink);
  }
  return sink.value();
}

/// The tip is led round a circle and turned, from wherever the blocks left it.
std::uint64_t led_hand_hash(std::size_t frames) {
  ArmAmongBlocks scene;
  const std::uint32_t tip = scene.mechanism->find_link("tip");
  ResolvedRate rates(*scene.mechanism, tip);
  BitSink sink;
  std::vector<double> step(scene.mechanism->value_count()), goal(step.size());
  for (std::size_t frame = 1; frame <= frames; ++frame) {
    const SineCosine round = sine_cosine(0.03 * static_cast<double>(frame));
    const Twist wanted{{0.05 * round.cosine, 0.05 * round.sine, 0.02}, {0.0, 0.01, 0.02 * round.sine}};
    const auto X_WL = scene.world.link_poses(scene.arm);
    const auto outcome = rates.solve(X_WL, X_WL[tip].p, wanted, step);
    sink.put(outcome.scale), sink.put(outcome.error.v), sink.put(outcome.error.w);
    for (std::size_t k = 0; k < goal.size(); ++k) goal[k] = scene.world.joint_values(scene.arm)[k] + step[k];
    scene.move(goal, sink);
  }
  return sink.value();
}

}  // namespace

std::vector<FamilyHash> world_hashes(std::size_t frames) {
  return {{"world: crowd that holds", crowd_hash(ContactPolicy::hold, frames)},
          {"world: crowd that advances", crowd_hash(ContactPolicy::advance, frames)},
          {"world: crowd that slides", crowd_hash(ContactPolicy::slide, frames)},
          {"world: arm swaying among blocks", swaying_arm_hash(frames)},
          {"world: hand led among blocks", led_hand_hash(frames)}};
}

std::vector<std::uint64_t> path_rotation_hashes(std::size_t count) {
  Random random(3);
  std::vector<std::uint64_t> hashes;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose from = random_pose(random, 1.0), to = random_pose(random, 1.0);
    BitSink sink;
    sink.put(RigidPath::between(from, to).pose_at(random.uniform(0.1, 0.9)).R);
    hashes.push_back(sink.value());
  }
  return hashes;
}

}  // namespace touchstone::proof
