#include <gtest/gtest.h>

#include <array>

#include "touchstone/tests/world/arms/arm_fixture.hpp"

// A frame's executed motion, asked for after objects came and went: a slot's new owner has none of the last
// one's.

namespace touchstone {
namespace {

void expect_at(const ContactWorld& world, ObjectHandle object, double x) {
  for (const double s : {0.0, 0.5, 1.0}) EXPECT_EQ(world.executed_pose(object, 0, s).p.x(), x) << "s " << s;
}

TEST(ExecutedParts, AnObjectInTheSlotOfOneThatMovedStoodStill) {
  const auto world = make_world();
  const ObjectHandle first = world->add({box_tree("first", {1, 1, 1}), at(0, 0, 0)});
  const std::array go{world->move_by(first, {5, 0, 0}, Vector3::Zero())};
  world->frame(go);
  EXPECT_EQ(world->executed_pose(first, 0, 0.5).p.x(), 2.5);
  world->remove(first);
  const ObjectHandle second = world->add({box_tree("second", {1, 1, 1}), at(20, 0, 0)});
  ASSERT_EQ(second.slot, first.slot);
  expect_at(*world, second, 20);
  world->prepare();
  expect_at(*world, second, 20);
}

TEST(ExecutedParts, AMechanismInTheSlotsOfAnotherStoodStill) {
  const auto world = make_world();
  const MechanismHandle two = world->add_mechanism({make_arm("two", 2)});
  move_joints(*world, two, {0.1, 0.1});
  world->remove_mechanism(two);
  const MechanismHandle six = world->add_mechanism({make_arm("six", 6)});
  std::array<double, 6> values;
  values.fill(1.0);
  world->executed_joints(six, 0, 0.5, values);
  for (const double value : values) EXPECT_EQ(value, 0.0);
}

TEST(ExecutedParts, WhatIsLatchedToAMoverAfterItsFrameStoodStill) {
  for (const int others : {0, 14, 15, 30, 31, 62, 63}) {  // whichever count makes lists grow
    const auto world = make_world();
    const ObjectHandle mover = world->add({box_tree("mover", {1, 1, 1}), at(0, 0, 0)});
    for (int i = 0; i < others; ++i)
      world->add({box_tree(std::to_string(i), {1, 1, 1}), at(0, 10.0 + 2.0 * i, 0)});
    const std::array go{world->move_by(mover, {5, 0, 0}, Vector3::Zero())};
    world->frame(go);
    const ObjectHandle late = world->add({box_tree("late", {1, 1, 1}), at(20, 0, 0)});
    world->latch(mover, late);
    expect_at(*world, late, 20);
    const std::array on{world->move_by(mover, {1, 0, 0}, Vector3::Zero())};
    world->frame(on);
    EXPECT_EQ(world->actual_pose(late).p.x(), 21.0);
  }
}

}  // namespace
}  // namespace touchstone
