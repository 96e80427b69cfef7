#include <gtest/gtest.h>

#include "tests/support/counting_allocator.hpp"
#include "world_fixture.hpp"

namespace touchstone {
namespace {

TEST(ContactWorld, NoFrameAllocatesWithAThousandObjects) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance, 0.01));
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

}  // namespace
}  // namespace touchstone
