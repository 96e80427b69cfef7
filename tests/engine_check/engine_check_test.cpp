#include <gtest/gtest.h>

#include <cmath>

#include "examples/engine_check/world.hpp"
#ifdef TOUCHSTONE_ENGINE_CHECK_ODE
#include <ode/ode.h>
#endif

// Worlds with closed-form answers, stepped in each engine with our check, and with its own where that is to
// be beaten. Every run is deterministic: bounds without a reason of their own are twice what came out.

namespace touchstone::engine_check {
namespace {

using Run = Outcome (*)(const World&, Check, PairObserver*);

/// Bounds of what is to stand still, over both kinds of shapes.
struct Stillness {
  double drift;  ///< [m]
  double speed;  ///< at the end [m/s]
};

struct Engine {
  Run run;
  Stillness stack, frusta, wall;
  /// MuJoCo's contacts give: by (1 - d) / d * g / k at rest, 1.1 mm each in the stacks (its solref and
  /// solimp, d = 0.9, k = 1 / (0.95 * 2 steps)^2), and more while sliding fast, so that its own check is the
  /// measure there.
  bool is_soft = false;
  double give() const { return is_soft ? 0.0015 : 0.0; }
};

class EngineWorlds : public testing::TestWithParam<Engine> {
 protected:
  static Outcome run(const World& world, Check check = Check::native) {
    return GetParam().run(world, check, nullptr);
  }
  static double off(const World& world, const Outcome& outcome) {
    return norm(Vector3(outcome.end - *world.end));
  }
  static void expect_still(const World& world, const Outcome& outcome, const Stillness& bounds) {
    EXPECT_LT(outcome.drift, bounds.drift) << world.name;
    EXPECT_LT(outcome.speed, bounds.speed) << world.name;
  }
  static double off_in_height(const World& world, const Outcome& outcome) {
    return std::abs(outcome.end.z() - world.end->z());
  }
};

TEST_P(EngineWorlds, AStackOfBoxesStandsAsHighAsWithTheEnginesOwnCheck) {
  for (const bool by_hulls : {false, true}) {
    const World world = stack(10, by_hulls);
    const Outcome ours = run(world);
    const Outcome own = run(stack(10, false), Check::engine);
    EXPECT_LT(off_in_height(world, ours), off_in_height(world, own) + 0.002) << world.name;
    expect_still(world, ours, GetParam().stack);
    EXPECT_LT(ours.lean, 0.05) << world.name;
  }
}

TEST_P(EngineWorlds, AWallStands) {
  for (const bool by_hulls : {false, true}) {
    const World world = wall(4, by_hulls);
    const Outcome ours = run(world);
    expect_still(world, ours, GetParam().wall);
    EXPECT_LT(off_in_height(world, ours), 0.002 + 4 * GetParam().give()) << world.name;
  }
}

TEST_P(EngineWorlds, AStackOfFrustaStands) {
  const World world = frustum_stack(8);
  const Outcome ours = run(world);
  EXPECT_LT(off_in_height(world, ours), 0.005 + 8 * GetParam().give());
  expect_still(world, ours, GetParam().frusta);
}

TEST_P(EngineWorlds, ABoxSlidesOverFlushBoxesAsOverOne) {
  for (const bool by_hulls : {false, true}) {
    const World world = seams(by_hulls);
    const Outcome ours = run(world);
    EXPECT_LT(off(world, ours), 0.02) << world.name;  // the step is 0.02 m long at the start
    const double rise = GetParam().is_soft ? 1.25 * run(world, Check::engine).rise : 0.001;
    EXPECT_LT(ours.rise, rise) << world.name;
    EXPECT_LT(ours.lean, 1e-3) << world.name;
  }
}

TEST_P(EngineWorlds, ALeaningBoxComesBackBelowTheTippingAngleAndFallsAboveIt) {
  EXPECT_LT(run(toppling(0.95)).lean, 0.2);
  EXPECT_NEAR(run(toppling(1.05)).lean, 1.5707963, 0.01);
}

#ifdef TOUCHSTONE_ENGINE_CHECK_BULLET
INSTANTIATE_TEST_SUITE_P(Bullet, EngineWorlds,
                         testing::Values(Engine{
                             &run_bullet, {0.2, 0.021}, {0.134, 0.0123}, {0.0022, 0.0013}}));

TEST(BulletsOwnCheck, CatchesOnSeamsOfHulls) {
  const World world = seams(true);
  EXPECT_GT(norm(Vector3(run_bullet(world, Check::engine).end - *world.end)), 1.0);
}
#endif

#ifdef TOUCHSTONE_ENGINE_CHECK_ODE
/// ODE takes its constraints in random order, and its numbers go on from one run to the next.
Outcome run_ode_seeded(const World& world, Check check, PairObserver* observer) {
  dRandSetSeed(0);
  return run_ode(world, check, observer);
}

INSTANTIATE_TEST_SUITE_P(Ode, EngineWorlds,
                         testing::Values(Engine{
                             &run_ode_seeded, {0.02, 0.054}, {0.027, 0.084}, {0.016, 0.0084}}));

TEST(OdesOwnCheck, LetsAStackOfHullsFall) {
  EXPECT_GT(run_ode_seeded(stack(10, true), Check::engine, nullptr).drift, 1.0);
}
#endif

#ifdef TOUCHSTONE_ENGINE_CHECK_MUJOCO
INSTANTIATE_TEST_SUITE_P(Mujoco, EngineWorlds,
                         testing::Values(Engine{
                             &run_mujoco, {1e-9, 1e-9}, {2e-9, 1e-10}, {0.009, 2e-6}, true}));

TEST(MujocosOwnCheck, LetsAStackOfHullsFallWhereOursStandsStill) {
  const World world = stack(10, true);
  EXPECT_GT(run_mujoco(world, Check::engine).drift, 1.0);
  const Outcome ours = run_mujoco(world, Check::native);
  EXPECT_LT(ours.drift, 1e-9);
  EXPECT_LT(ours.speed, 1e-9);
}

TEST(MujocosOwnCheck, LetsAStackOfBoxesSinkDeeperAndDriftMore) {
  const World world = stack(10, false);
  const Outcome own = run_mujoco(world, Check::engine), ours = run_mujoco(world, Check::native);
  EXPECT_LT(std::abs(ours.end.z() - world.end->z()), 0.6 * std::abs(own.end.z() - world.end->z()));
  EXPECT_LT(ours.drift, 0.1 * own.drift);
  EXPECT_LT(ours.speed, 0.1 * own.speed);
}
#endif

}  // namespace
}  // namespace touchstone::engine_check
