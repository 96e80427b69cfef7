// Steps that bring the code of steps into the processor's caches: they succeed, and change nothing of other
// worlds.

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <vector>

#include "touchstone/physics/world/step/trial_steps.hpp"
#include "touchstone/tests/physics/cubes.hpp"

namespace touchstone::physics {
namespace {

TEST(TrialSteps, AreTaken) {
  for (int i = 0; i < 2; ++i) EXPECT_EQ(stepping::take_trial_steps(), StepFailure::none);
}

/// Of the bits of all that a run shows.
struct RunHash {
  std::uint64_t value = 14695981039346656037u;

  void add(double figure) { value = (value ^ std::bit_cast<std::uint64_t>(figure)) * 1099511628211u; }
  void add(const Vector3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const StepReport& r) {
    add(static_cast<double>(r.failure));
    for (const std::uint32_t count :
         {r.failed_index, r.solves, r.unconverged, r.sweeps, r.newton_steps, r.contradictory, r.substeps})
      add(count);
    for (const double figure : {r.worst_residual, r.worst_joint_error, r.last_stop}) add(figure);
    add(r.is_work_spent ? 1.0 : 0.0);
  }
  void add(const RigidBodyState& s) {
    for (const Vector3& v : {s.p_W, s.momentum_W, s.angular_W, s.p_low_W, s.low_W, s.turn_low_W}) add(v);
    add(s.q_WB.w), add(s.q_WB.v);
  }
};

/// Cubes that overlap, fall and come to rest, under a press.
std::vector<std::uint64_t> run_hashes(bool is_reserved) {
  Cubes scene;
  scene.add_ground();
  std::vector<std::uint32_t> cubes;
  for (int i = 0; i < 6; ++i)
    cubes.push_back(scene.add_cube({0.01 * i, 0.005 * (i % 3), kCubeSide * (0.45 + 0.99 * i)}));
  scene.add_driven({0, 0, 7.2 * kCubeSide}, {0, 0, -0.1});
  scene.contacts->build();
  if (is_reserved) scene.world.reserve(200);
  std::vector<std::uint64_t> hashes;
  RunHash hash;
  for (int i = 0; i < 400; ++i) {
    hash.add(scene.step(1e-3));
    for (const std::uint32_t cube : cubes) hash.add(scene.world.state(cube));
    hashes.push_back(hash.value);
    if (is_reserved && i % 100 == 50) stepping::take_trial_steps();
  }
  return hashes;
}

TEST(TrialSteps, ChangeNoBitOfOtherWorlds) { EXPECT_EQ(run_hashes(true), run_hashes(false)); }

}  // namespace
}  // namespace touchstone::physics
