#include "touchstone/contact_core/output/output_feed.hpp"

#include <gmock/gmock.h>

#include <array>

#include "output_fixture.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

/// Keeps what it is brought.
class Keeper final : public FrameOutput {
 public:
  std::vector<std::string> names;
  std::vector<MadeFrame> frames;

  void add_object(const OutputObject& object) override { names.push_back(object.name); }
  void write(const OutputFrame& frame) noexcept override {
    if (is_counting) return;
    frames.push_back({frame.frame,
                      frame.time,
                      {frame.poses.begin(), frame.poses.end()},
                      {frame.events.begin(), frame.events.end()}});
  }
  OutputStatus status() const noexcept override { return {}; }
  bool is_counting = false;
};

struct CubeOverTable {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle table = world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true});
  ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0)});

  FrameReport move(const Vector3& displacement) {
    const std::array commands{world->move_by(cube, displacement, {0, 0, 0})};
    return world->frame(commands);
  }
};

TEST(OutputFeed, BringsActualPosesNeverTheCommandedOnes) {
  CubeOverTable scene;
  Keeper keeper;
  OutputFeed feed(*scene.world);
  feed.show(scene.table);
  feed.add_output(keeper);
  feed.show(scene.cube);
  EXPECT_THAT(keeper.names, ::testing::ElementsAre("table", "cube"));

  feed.send(scene.move({0, 0, -0.8}), 0.1);  // held: the step is not executed
  ASSERT_EQ(keeper.frames.size(), 1u);
  const MadeFrame& frame = keeper.frames[0];
  EXPECT_EQ(frame.time, 0.1);
  ASSERT_EQ(frame.poses.size(), 2u);
  EXPECT_EQ(frame.poses[1].object, scene.cube);
  EXPECT_EQ(frame.poses[1].X_WO.p.z(), 1.0);
  EXPECT_EQ(scene.world->commanded_pose(scene.cube).p.z(), 1.0 - 0.8);
  ASSERT_EQ(frame.events.size(), 1u);
  EXPECT_EQ(frame.events[0].kind, EventKind::blocked);
}

TEST(OutputFeed, LeavesOutWhatWasRemoved) {
  CubeOverTable scene;
  Keeper keeper;
  OutputFeed feed(*scene.world);
  feed.add_output(keeper);
  feed.show(scene.table);
  feed.show(scene.cube);
  feed.send(scene.move({0, 0, 0.1}), 0.0);
  scene.world->remove(scene.cube);
  feed.send(scene.world->frame({}), 0.1);
  EXPECT_EQ(keeper.frames[0].poses.size(), 2u);
  ASSERT_EQ(keeper.frames[1].poses.size(), 1u);
  EXPECT_EQ(keeper.frames[1].poses[0].object, scene.table);
}

TEST(OutputFeed, RefusesUnknownAndTwice) {
  CubeOverTable scene;
  OutputFeed feed(*scene.world);
  feed.show(scene.cube);
  EXPECT_THROW(feed.show(scene.cube), InputError);
  EXPECT_THROW(feed.show({77, 0}), InputError);
}

TEST(OutputFeed, AllocatesNothing) {
  CubeOverTable scene;
  Keeper keeper;
  keeper.is_counting = true;
  OutputFeed feed(*scene.world);
  feed.add_output(keeper);
  feed.show(scene.table);
  feed.show(scene.cube);
  const FrameReport report = scene.move({0, 0, 0.1});
  const std::size_t before = allocation_count();
  for (int i = 0; i < 100; ++i) feed.send(report, i);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace touchstone
