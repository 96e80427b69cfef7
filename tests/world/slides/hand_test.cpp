#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

// How stiffly a hand holds what it flies, and what it feels. Closed forms: the spring's least energy.

namespace touchstone {
namespace {

double turn_of(const Pose& X) { return norm(RigidPath::between(Pose{}, X).at(0, 0).angular_velocity_W); }

/// A square peg of 0.1 x 0.1 x 0.3 m over a hole of 1e-6 m play, 1.5e-6 m beside it.
struct PegBesideItsHole {
  static constexpr double kWidth = 0.1, kPlay = 1e-6, kDeep = 0.3, kBeside = 1.5e-6;
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle peg;

  PegBesideItsHole() {
    world->set_default_rule(rule(ContactPolicy::slide));
    for (const double side : {1.0, -1.0}) {
      const double y = side * (0.5 * kWidth + kPlay + 0.25);
      const std::string name = side > 0 ? "+" : "-";
      world->add({box_tree("x" + name, {0.5, 1.5, kDeep}), at(y, 0, -0.5 * kDeep), true});
      world->add({box_tree("y" + name, {1.5, 0.5, kDeep}), at(0, y, -0.5 * kDeep), true});
    }
    peg = world->add({box_tree("peg", {kWidth, kWidth, 0.3}), at(kBeside, 0, 0.15 + 1e-3)});
  }

  void press() {
    const std::array commands{world->go_to(peg, at(kBeside, 0, 0.15 - 0.2))};
    for (int frame = 0; frame < 20; ++frame) world->frame(commands);
  }
};

TEST(Hand, APegBesideItsHoleDoesNotTip) {
  PegBesideItsHole by_hand;
  by_hand.world->set_hand(by_hand.peg, HandStiffness{});
  by_hand.press();
  const Pose& X = by_hand.world->actual_pose(by_hand.peg);
  EXPECT_LT(turn_of(X), std::numbers::pi / 180);
  EXPECT_NEAR(X.p.z(), 0.15, 2e-3);

  PegBesideItsHole by_mass;  // as a body that hangs free: it falls over, which brings its centre down
  by_mass.world->set_hand(by_mass.peg, std::nullopt);
  by_mass.press();
  EXPECT_GT(turn_of(by_mass.world->actual_pose(by_mass.peg)), 0.5);
}

// A box commanded to go 1 mm into the floor: the spring holds it up with 500 N/m.
TEST(Hand, FeelsTheFloor) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(0, 0, 0.2 + 1e-3)});
  world->set_hand(box, HandStiffness{});
  const std::array commands{world->go_to(box, at(0.1, 0, 0.2 - 1e-3))};
  const FrameReport report = world->frame(commands);
  ASSERT_EQ(report.felt.size(), 1u);
  const HandFeel& felt = report.felt[0];
  EXPECT_EQ(felt.object, box);
  EXPECT_NEAR(felt.lag_W.z(), -1e-3, 1e-8);
  EXPECT_NEAR(felt.lag_W.x(), 0.0, 1e-9);
  EXPECT_NEAR(felt.force_W.z(), 0.5, 1e-5);
  EXPECT_NEAR(felt.force_W.x(), 0.0, 1e-12);
  EXPECT_LT(norm(felt.moment_W), 1e-6);
  EXPECT_LT(norm(felt.p_W - world->actual_pose(box).p), 1e-12);
  // Away from it there is nothing to feel.
  const std::array away{world->go_to(box, at(0.1, 0, 0.5))};
  EXPECT_TRUE(world->frame(away).felt.empty());
}

// Held by one end and pressed on a block under the other: force and moment are the lever's.
TEST(Hand, FeelsTheMomentOfALever) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("block", {0.02, 1, 1}), at(1.0, 0, -0.5), true});
  const ObjectHandle bar = world->add({box_tree("bar", {2, 0.1, 0.1}), at(0, 0, 0.05 + 1e-4)});
  HandStiffness hand;
  hand.X_OT = at(-1, 0, 0);
  hand.translation = {1000, 1000, 1000}, hand.turning = {200, 200, 200};
  world->set_hand(bar, hand);
  const std::array commands{world->go_to(bar, at(0, 0, 0.05 - 1e-3))};
  FrameReport report;
  for (int frame = 0; frame < 10; ++frame) report = world->frame(commands);
  ASSERT_EQ(report.felt.size(), 1u);
  const HandFeel& felt = report.felt[0];
  // Two springs in a row at the end of a lever r: the end is held up by h, f (1 / k + r^2 / c) = h.
  const double r = 1.99, h = 1e-3, f = h / (1 / 1000.0 + r * r / 200.0);
  EXPECT_NEAR(felt.force_W.z(), f, 0.01 * f);
  EXPECT_NEAR(felt.moment_W.y(), -r * f, 0.01 * r * f);
  EXPECT_NEAR(felt.lag_W.z(), -f / 1000.0, 0.01 * f / 1000.0);
  EXPECT_NEAR(felt.turn_lag_W.y(), r * f / 200.0, 0.01 * r * f / 200.0);
}

// Pressed on a slope by a hand that is four times as stiff across it: d = g - K^-1 n (n . g) / (n . K^-1 n).
TEST(Hand, AStifferAxisGivesLess) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  const Pose X_box = add_slope(*world);
  const Vector3 n = X_box.R.col(2);
  const ObjectHandle box = world->add({box_tree("box", {0.2, 0.2, 0.2}), X_box});
  HandStiffness hand;
  Pose X_OT;
  X_OT.R = X_box.R.transpose();  // along the world's axes
  hand.X_OT = X_OT;
  hand.translation = {400, 400, 100};
  world->set_hand(box, hand);
  const Vector3 g(0.0, 0.0, -0.01);
  Pose goal = X_box;
  goal.p += g;
  const std::array commands{world->go_to(box, goal)};
  for (int frame = 0; frame < 5; ++frame) world->frame(commands);
  const Vector3 K_n(n.x() / 400, n.y() / 400, n.z() / 100);
  const Vector3 expected = g - (dot(n, g) / dot(n, K_n)) * K_n;
  const Vector3 moved = world->actual_pose(box).p - X_box.p;
  EXPECT_LT(norm(moved - expected), 5e-6);
  const Vector3 even = g - dot(n, g) * n;
  EXPECT_GT(norm(moved - even), 1e-3);
}

TEST(Hand, RefusesWhatIsNoHand) {
  const auto world = make_world();
  const ObjectHandle box = world->add({box_tree("box", {1, 1, 1}), {}});
  HandStiffness hand;
  hand.translation.y() = 0.0;
  EXPECT_THROW(world->set_hand(box, hand), InputError);
  hand.translation = {1e-3, 1, 1e5};
  EXPECT_THROW(world->set_hand(box, hand), InputError);
  hand = {};
  hand.turning.z() = kNaN;
  EXPECT_THROW(world->set_hand(box, hand), InputError);
  hand = {};
  hand.X_OT = at(1e9, 0, 0);
  EXPECT_THROW(world->set_hand(box, hand), InputError);
  EXPECT_THROW(world->set_default_hand(hand), InputError);
  EXPECT_THROW(world->set_hand({}, HandStiffness{}), InputError);
}

// A hand is its object's: not of whoever gets the slot next. Frames do not allocate.
TEST(Hand, EndsWithItsObjectAndCostsNoAllocation) {
  PegBesideItsHole scene;
  scene.world->set_default_hand(std::nullopt);
  scene.world->set_hand(scene.peg, HandStiffness{});
  scene.world->remove(scene.peg);
  scene.peg = scene.world->add({box_tree("peg", {0.1, 0.1, 0.3}), at(1.5e-6, 0, 0.15 + 1e-3)});
  scene.world->frame({});
  scene.press();
  EXPECT_GT(turn_of(scene.world->actual_pose(scene.peg)), 0.5);
  HandStiffness uneven;
  uneven.translation = {100, 200, 300}, uneven.turning = {5, 10, 20};
  scene.world->set_hand(scene.peg, uneven);
  const std::array commands{scene.world->go_to(scene.peg, at(0.3, 0, -0.1))};
  for (int frame = 0; frame < 5; ++frame) scene.world->frame(commands);
  const std::size_t before = allocation_count();
  std::size_t felt = 0;
  for (int frame = 0; frame < 20; ++frame) felt += scene.world->frame(commands).felt.size();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(felt, 0u);
}

}  // namespace
}  // namespace touchstone
