// A contact world over a backend that only judges poses: `edge_face`, which core has.

#include <gmock/gmock.h>

#include <array>

#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;

std::unique_ptr<Narrowphase> make(std::string_view name) {
  BackendRegistry registry;
  register_core(registry);
  return registry.make_narrowphase(name);
}

TEST(SampledWorld, SaysSoAndIsSwappedInPlace) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true});
  const ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0)});
  const auto move = [&](const Vector3& by) {
    return world->frame(std::array{world->move_by(cube, by, {0.3, 0, 0})});
  };
  EXPECT_EQ(world->capabilities().check, MotionCheck::proven);
  EXPECT_EQ(world->capabilities().narrowphase, "native");
  EXPECT_EQ(move({0, 0, 0.1}).check, MotionCheck::proven);
  world->set_narrowphase(make("edge_face"));
  EXPECT_EQ(world->capabilities().check, MotionCheck::sampled);
  EXPECT_EQ(world->capabilities().narrowphase, "edge_face");
  const FrameReport report = move({0, 0, -2});
  EXPECT_EQ(report.check, MotionCheck::sampled);
  EXPECT_THAT(kinds(report), Contains(EventKind::blocked));
  EXPECT_THAT(kinds(report), Contains(EventKind::began));
  world->set_narrowphase(make("native"));
  EXPECT_EQ(move({0, 0, 0.1}).check, MotionCheck::proven);
  EXPECT_EQ(to_string(MotionCheck::sampled), "sampled");
}

// The backend judges: what it is blind to is neither stopped nor reported.
TEST(SampledWorld, ABlindSpotIsLetThrough) {
  for (const bool blind : {false, true}) {
    const auto world = make_world();
    world->set_narrowphase(make(blind ? "edge_face" : "native"));
    world->set_default_rule(rule(ContactPolicy::advance));
    world->add({box_tree("box", {1, 1, 1}), at(0, 0, 0), true});
    const ObjectHandle cube = world->add({box_tree("cube", {0.1, 0.1, 0.1}), at(0, 0, 0.1)});
    const FrameReport report = world->frame(std::array{world->move_by(cube, {0, 0, -0.1}, {0, 0, 0})});
    if (blind) {
      EXPECT_THAT(kinds(report), IsEmpty());
      EXPECT_EQ(world->actual_pose(cube).p.z(), 0.0);
    } else {
      EXPECT_THAT(kinds(report), Contains(EventKind::penetrating_at_start));
      EXPECT_EQ(world->actual_pose(cube).p.z(), 0.1);
    }
  }
}

TEST(SampledWorld, NoFrameAllocates) {
  const auto world = make_world();
  world->set_narrowphase(make("edge_face"));
  world->set_default_rule(rule(ContactPolicy::slide));
  world->add({box_tree("floor", {6, 6, 1}), at(0, 0, -0.5), true});
  std::vector<ObjectHandle> boxes;
  for (int i = 0; i < 20; ++i)
    boxes.push_back(world->add({box_tree("box " + std::to_string(i), {0.4, 0.4, 0.4}),
                                at(0.5 * (i % 5) - 1, 0.5 * (i / 5) - 1, 0.4)}));
  std::vector<MotionCommand> commands;
  commands.reserve(boxes.size());
  std::size_t before = 0, blocked = 0;
  for (int frame = 0; frame < 60; ++frame) {
    if (frame == 20) before = allocation_count();
    commands.clear();
    const double sign = frame / 10 % 2 ? 1.0 : -1.0;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      commands.push_back(
          world->move_by(boxes[i], {sign * 0.02, 0.01 * static_cast<double>(i % 3), -0.02}, {0, 0, 0.01}));
    blocked += world->frame(commands).blocked_movers;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(blocked, 0u);
}

}  // namespace
}  // namespace touchstone
