#include <gtest/gtest.h>

#include <array>

#include "tests/support/counting_allocator.hpp"
#include "world_fixture.hpp"

namespace touchstone {
namespace {

class FrameAllocations : public ::testing::TestWithParam<ContactPolicy> {};

TEST_P(FrameAllocations, NoneWithAThousandObjects) {
  const auto world = make_world();
  world->set_default_rule(rule(GetParam(), 0.01));
  std::vector<ObjectHandle> objects;
  for (int i = 0; i < 1000; ++i) {
    objects.push_back(world->add({box_tree("box " + std::to_string(i), {1, 1, 1}),
                                  at(1.3 * (i % 10), 1.3 * (i / 10 % 10), 1.3 * (i / 100)), i % 10 == 0}));
  }
  std::vector<MotionCommand> commands;
  commands.reserve(1000);
  std::size_t before = 0;
  std::size_t blocked = 0;
  for (int frame = 0; frame < 40; ++frame) {
    if (frame == 20) before = allocation_count();
    commands.clear();
    for (int i = 0; i < 1000; ++i) {
      const double sign = (frame / 10 + i) % 2 ? 1.0 : -1.0;
      commands.push_back(
          world->move_by(objects[i], sign * Vector3(0.02, 0.01 * (i % 3), 0.015), {0, 0, sign * 0.02}));
    }
    blocked += world->frame(commands).blocked_movers;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(blocked, 0u);
}

INSTANTIATE_TEST_SUITE_P(Policies, FrameAllocations,
                         ::testing::Values(ContactPolicy::hold, ContactPolicy::advance,
                                           ContactPolicy::slide));

// One that presses and slides in a corner, where every frame takes sub-steps.
TEST(SlideAllocations, NoneWhileSliding) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  world->add({box_tree("wall", {1, 6, 4}), at(2.5, 0, 2), true});
  const ObjectHandle box = world->add({box_tree("box", {0.6, 0.5, 0.4}), at(1.6, 0, 0.3)});
  std::size_t before = 0, slid = 0;
  for (int frame = 0; frame < 200; ++frame) {
    if (frame == 10) before = allocation_count();
    const double sign = frame / 20 % 2 ? 1.0 : -1.0;
    const std::array commands{world->move_by(box, {0.01, sign * 0.02, -0.01}, {0.01, 0, sign * 0.01})};
    slid += world->frame(commands).slide_steps > 0;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(slid, 150u);
}

}  // namespace
}  // namespace touchstone
