// When pairs begin to touch and part, and what surfaces their contacts have.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "touchstone/physics/contacts/touch_events.hpp"
#include "touchstone/physics/engine/engine_features.hpp"
#include "touchstone/physics/engine/engine_scene.hpp"
#include "touchstone/tests/physics/hand_made_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone::physics {
namespace {

using Kind = TouchEvent::Kind;

TouchPoint point(SolidIndex a, SolidIndex b, double separation, double impulse) {
  return {{a, b}, kZero, Vector3::UnitZ(), separation, {0, 0, impulse}, kZero};
}

/// "b01 p23 e45": kinds and pairs.
std::string said(const TouchEvents& events) {
  std::string out;
  for (const TouchEvent& event : events.events())
    out += (out.empty() ? "" : " ") + std::string(1, to_string(event.kind)[0]) +
           std::to_string(event.solids.a) + std::to_string(event.solids.b);
  return out;
}

TEST(TouchEvents, BeginAtTheGapOrAnImpulseAndEndBeyondTwiceTheGapWithoutOne) {
  TouchEvents events(1e-6);
  const auto step = [&](const std::vector<TouchPoint>& points) {
    events.begin();
    for (const TouchPoint& each : points) events.add(each);
    events.finish();
    return said(events);
  };
  EXPECT_EQ(step({point(0, 1, 1.1e-6, 0.0)}), "");
  EXPECT_EQ(step({point(0, 1, 1e-6, 0.0)}), "b01");
  EXPECT_EQ(step({point(0, 1, 1.9e-6, 0.0)}), "p01");
  EXPECT_EQ(step({point(0, 1, 2.1e-6, 0.0)}), "e01");
  EXPECT_EQ(step({point(0, 1, 1.9e-6, 0.0)}), "");   // ended: the first gap counts again
  EXPECT_EQ(step({point(0, 1, 1e-3, 0.5)}), "b01");  // met within the step
  EXPECT_EQ(step({}), "e01");                        // no longer found
  EXPECT_EQ(step({}), "");
  // Points in any order; those beyond do not count among a pair's.
  EXPECT_EQ(
      step({point(2, 3, 0.0, 1.0), point(0, 1, 0.0, 2.0), point(2, 3, 1e-3, 0.0), point(2, 3, 0.0, 3.0)}),
      "b01 b23");
  const TouchEvent& event = events.events()[1];
  EXPECT_EQ(event.points, 2u);
  EXPECT_EQ(events.points_of(event)[1].impulse_W.z(), 3.0);
  EXPECT_EQ(event.impulse_W.z(), 4.0);
  events.forget();
  EXPECT_EQ(step({point(0, 1, 0.0, 1.0)}), "b01");
}

/// A ball that bounces, a box that slides off a table and falls on the floor.
TEST(TouchEvents, ABounceBeginsAndEndsAndItsImpulseIsTheMomentumTurned) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -9.81};
  const Vector3 size(0.1, 0.1, 0.1);
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {.surface = {0.0, 0.5}});
  add(scene, box("block", size, at({0, 0, 0.25})), free_body(2.0, size));
  SceneSimulation simulation(scene, native_contacts);
  simulation.watch_touches(true);
  ASSERT_EQ(step(simulation).failure, StepFailure::none);
  std::vector<double> begins;
  double impulse = 0.0, impact = 0.0;
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    for (const TouchEvent& event : simulation.touches().events()) {
      if (event.kind == Kind::began) begins.push_back(simulation.time());
      if (begins.size() == 1) impulse += event.impulse_W.z(), impact += event.impact_W.z();
      EXPECT_EQ(simulation.solid_name(event.solids.a), "floor/box");
    }
  }
  const double fall = std::sqrt(2 * 0.2 / 9.81), v = 9.81 * fall;
  ASSERT_GE(begins.size(), 4u);
  EXPECT_NEAR(begins[0], fall, scene.step);
  EXPECT_NEAR(begins[1], fall + 2 * 0.5 * v / 9.81, 2 * scene.step);
  EXPECT_NEAR(impact, 2.0 * 1.5 * v, 1e-8);
  EXPECT_NEAR(impulse, impact, 1e-2);
  // Then it lies there.
  ASSERT_EQ(simulation.touches().events().size(), 1u);
  EXPECT_EQ(simulation.touches().events()[0].kind, Kind::persisted);
  EXPECT_EQ(simulation.touches().events()[0].points, 4u);
  EXPECT_NEAR(simulation.touches().events()[0].impulse_W.z(), 2.0 * 9.81 * scene.step, 1e-9);
}

TEST(TouchEvents, SleepersGoOnTouchingAndNothingIsAllocated) {
  DynamicScene scene = empty_scene(1.0);
  scene.gravity_W = {0, 0, -9.81};
  scene.sleep_time = 0.1;
  const Vector3 size(0.1, 0.1, 0.1);
  add(scene, box("floor", {4, 4, 1}, at({0, 0, -0.5})), {});
  add(scene, box("a", size, at({0, 0, 0.05})), free_body(1.0, size));
  add(scene, box("b", size, at({0, 0, 0.15})), free_body(1.0, size));
  SceneSimulation simulation(scene, native_contacts);
  simulation.watch_touches(true);
  for (int i = 0; i < 10; ++i) ASSERT_EQ(step(simulation).failure, StepFailure::none);
  const std::uint64_t before = allocation_count();
  int other = 0;
  while (!simulation.is_over()) {
    ASSERT_EQ(step(simulation).failure, StepFailure::none);
    other += said(simulation.touches()) == "p01 p12" ? 0 : 1;
  }
  EXPECT_EQ(allocation_count() - before, 0u);
  EXPECT_EQ(other, 0);
  EXPECT_TRUE(simulation.world().is_asleep(*simulation.dynamic_body(1)));
  EXPECT_NEAR(simulation.touches().events()[0].impulse_W.z(), 2.0 * 9.81 * scene.step, 1e-9);
  EXPECT_NEAR(simulation.touches().events()[1].impulse_W.z(), 1.0 * 9.81 * scene.step, 1e-9);
}

// ---- surfaces

TEST(SurfacePairs, CombineByTheRuleUnlessThePairHasItsOwn) {
  // Each rule, in either order.
  const Surface a{0.9, 0.2}, b{0.4, 0.6};
  const std::map<Combination, double> frictions{{Combination::geometric_mean, 0.6},
                                                {Combination::arithmetic_mean, 0.65},
                                                {Combination::minimum, 0.4},
                                                {Combination::maximum, 0.9},
                                                {Combination::product, 0.36}};
  ASSERT_EQ(frictions.size(), kCombinations);
  for (const auto& [rule, friction] : frictions) {
    SurfacePairs pairs;
    pairs.friction_rule = rule;
    EXPECT_NEAR(pairs.between(0, a, 1, b).friction, friction, 1e-15) << to_string(rule);
    EXPECT_EQ(pairs.between(0, a, 1, b).friction, pairs.between(1, b, 0, a).friction);
    EXPECT_EQ(pairs.between(0, a, 1, b).restitution, 0.6);
  }
  // Pairs with figures of their own; what they leave open is combined.
  SurfacePairs pairs;
  EXPECT_TRUE(pairs.is_usual());
  pairs.set(5, 2, {0.1, {}});
  pairs.set(1, 7, {{}, 0.9});
  pairs.set(2, 5, {0.3, {}});  // the last one counts
  EXPECT_FALSE(pairs.is_usual());
  EXPECT_EQ(pairs.between(2, a, 5, b).friction, 0.3);
  EXPECT_EQ(pairs.between(2, a, 5, b).restitution, 0.6);
  EXPECT_EQ(pairs.between(7, a, 1, b).restitution, 0.9);
  EXPECT_NEAR(pairs.between(7, a, 1, b).friction, 0.6, 1e-15);
  EXPECT_NEAR(pairs.between(5, a, 7, b).friction, 0.6, 1e-15);
}

/// Two boxes on a slope's equivalent: each decelerates by its pair's friction.
TEST(SurfacePairs, BoxesSlideByTheirPairsFriction) {
  DynamicScene scene = empty_scene(0.1);
  scene.gravity_W = {0, 0, -10};
  const Vector3 size(0.2, 0.2, 0.2);
  add(scene, box("floor", {40, 4, 1}, at({0, 0, -0.5})), {.surface = {0.5, 0.0}});
  for (const double y : {-0.5, 0.5}) {
    SceneBody body = free_body(1.0, size, {2, 0, 0});
    body.surface.friction = 0.5;
    add(scene, box(y < 0 ? "a" : "b", size, at({0, y, 0.1})), body);
  }
  scene.pairs.push_back({0, 1, 0.5, {}, {}});
  scene.pairs.push_back({1, 0, 0.2, {}, {}});
  SceneSimulation simulation(scene, native_contacts);
  run(simulation);
  EXPECT_NEAR(simulation.velocity(1)->x(), 2.0 - 0.2 * 10 * 0.1, 1e-9);
  EXPECT_NEAR(simulation.velocity(2)->x(), 2.0 - 0.5 * 10 * 0.1, 1e-9);
  // The same figures for engines, and what an engine of one friction lacks.
  const EngineScene engine(scene);
  EXPECT_EQ(engine.friction(0, 1), 0.2);
  EXPECT_EQ(engine.friction(2, 0), 0.5);
  EXPECT_FALSE(engine.has_usual_surfaces());
  const std::vector<std::string> lacking = unsupported(EngineFeatures{}, scene);
  ASSERT_EQ(lacking.size(), 1u);
  EXPECT_EQ(lacking[0], "friction that differs between objects (object 'floor' and object 'a')");
}

TEST(SurfacePairs, ScenesRefusePairsThatAreNone) {
  const auto error_of = [](const ScenePair& pair) -> std::string {
    DynamicScene scene = empty_scene(0.1);
    add(scene, box("a", {1, 1, 1}, at({0, 0, 0})), {});
    add(scene, box("b", {1, 1, 1}, at({3, 0, 0})), {});
    scene.pairs.push_back(pair);
    return refusal_of([&] { validate(scene); });
  };
  EXPECT_EQ(error_of({0, 1, 0.5, {}, {}}), "accepted");
  EXPECT_EQ(error_of({0, 2, 0.5, {}, {}}), "pair: no such object");
  EXPECT_EQ(error_of({1, 1, 0.5, {}, {}}), "pair: object 'b' is no pair with itself");
  EXPECT_EQ(error_of({0, 1, -0.5, {}, {}}), "pair: friction must be >= 0");
  EXPECT_EQ(error_of({0, 1, {}, 1.5, {}}), "pair: restitution must be from 0 to 1");
}

}  // namespace
}  // namespace touchstone::physics
