#include "touchstone/contact_core/world/contact_world.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/degree.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A 1 m cube above a table whose top is at z = 0.
struct CubeOverTable {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle table = world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true});
  ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0)});

  FrameReport move(const Vector3& displacement, const Vector3& turn = Vector3::Zero()) {
    const std::array commands{world->move_by(cube, displacement, turn)};
    return world->frame(commands);
  }
  double height() const { return world->actual_pose(cube).p.z() - 0.5; }
};

TEST(ContactWorld, HoldDoesNotExecuteTheStep) {
  CubeOverTable scene;
  const FrameReport report = scene.move({0, 0, -0.8});
  EXPECT_EQ(scene.height(), 0.5);
  EXPECT_EQ(report.blocked_movers, 1u);
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::blocked));
  EXPECT_NEAR(report.events[0].s, 0.5 / 0.8, 1e-8);
}

TEST(ContactWorld, AdvanceGoesUpToTheContactAndReportsIt) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::advance));
  FrameReport report = scene.move({0, 0, -0.8});
  EXPECT_GE(scene.height(), 0.5 * kGap * (1 - 1e-6));
  EXPECT_LE(scene.height(), kGap * (1 + 1e-6));
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::blocked, EventKind::began));
  report = scene.move({0.1, 0, 0});
  EXPECT_NEAR(scene.world->actual_pose(scene.cube).p.x(), 0.1, 0.0);
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::persists));
  report = scene.move({0, 0, 0.2});
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::ended));
  EXPECT_THAT(kinds(scene.move({0, 0, 0.1})), IsEmpty());
}

TEST(ContactWorld, CueReportsAndLetsItMove) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::cue));
  const FrameReport report = scene.move({0, 0, -0.8});
  EXPECT_NEAR(scene.height(), -0.3, 1e-15);
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::began));
  EXPECT_NEAR(report.events[0].s, 0.5 / 0.8, 1e-8);
  EXPECT_LE(report.events[0].geometry.separation, kGap);
  EXPECT_GT(report.events[0].geometry.separation, 0.0);
  EXPECT_NEAR(report.events[0].geometry_at_end.separation, -0.3, 1e-12);
}

// 1e155 m squared overflows: how far the cube may have gone is not known, and stays so if sums are kept.
TEST(ContactWorld, CommandBeyondTheSquareRootOfAllNumbersIsNoLicenceToTunnel) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::advance));
  scene.world->add({box_tree("roof", {4, 4, 1}), at(0, 0, 10), true});
  EXPECT_EQ(scene.move({0, 0, -1e155}).blocked_movers, 1u);
  EXPECT_GT(scene.height(), 0.0);
  scene.move({0, 0, 3});
  EXPECT_EQ(scene.move({0, 0, 30}).blocked_movers, 1u);
  EXPECT_LT(scene.height(), 8.5);
  EXPECT_EQ(scene.move({0, 0, -30}).blocked_movers, 1u);
  EXPECT_GT(scene.height(), 0.0);
}

TEST(ContactWorld, SolidPosesAreThereOnceSetUpIsTakenUp) {
  CubeOverTable scene;
  EXPECT_TRUE(scene.world->solid_poses(scene.cube).empty());
  scene.world->prepare();
  ASSERT_EQ(scene.world->solid_poses(scene.cube).size(), 1u);
  EXPECT_EQ(scene.world->solid_poses(scene.cube)[0].p, Vector3(0, 0, 1));
  const ObjectHandle other = scene.world->add({box_tree("other", {1, 1, 1}), at(5, 0, 1)});
  EXPECT_TRUE(scene.world->solid_poses(other).empty());
  scene.world->frame({});
  EXPECT_EQ(scene.world->solid_poses(other).size(), 1u);
}

TEST(ContactWorld, SelectionThatWaitsDoesNotOutliveReset) {
  CubeOverTable scene;
  scene.world->select(SelectionChange::of_everything(false));
  scene.world->reset();
  EXPECT_EQ(scene.move({0, 0, -0.8}).blocked_movers, 1u);
}

TEST(ContactWorld, ContactsOutliveSetUpAndEndWithTheirObjects) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::advance));
  scene.move({0, 0, -0.8});
  const ObjectHandle first = scene.world->add({box_tree("first", {1, 1, 1}), at(0, 9, 9)});
  EXPECT_THAT(kinds(scene.move({0, 0, 0})), ElementsAre(EventKind::persists));
  scene.world->remove(first);
  scene.world->set_default_rule(rule(ContactPolicy::slide));
  EXPECT_THAT(kinds(scene.move({0, 0, 0})), ElementsAre(EventKind::persists));
  scene.world->remove(scene.table);
  const FrameReport report = scene.move({0, 0, 0});
  ASSERT_THAT(kinds(report), ElementsAre(EventKind::ended));
  EXPECT_EQ(report.events[0].a, scene.table);
  EXPECT_EQ(report.events[0].b, scene.cube);
  EXPECT_THAT(kinds(scene.move({0, 0, 0})), IsEmpty());
}

TEST(ContactWorld, WarnsWhenNear) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::hold, 0.1));
  EXPECT_THAT(kinds(scene.move({0, 0, -0.3})), IsEmpty());
  EXPECT_THAT(kinds(scene.move({0, 0, -0.15})), ElementsAre(EventKind::near));
}

TEST(ContactWorld, PairRuleStandsBeforeGroupRuleBeforeDefault) {
  const auto world = make_world();
  const ObjectHandle table = world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true, {"furniture"}});
  const ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0), false, {"cargo"}});
  const auto lower = [&] { return world->frame(std::array{world->move_by(cube, {0, 0, -0.8}, {0, 0, 0})}); };
  const auto height = [&] { return world->actual_pose(cube).p.z() - 0.5; };
  world->set_group_rule("cargo", "furniture", rule(ContactPolicy::advance));
  lower();
  EXPECT_LT(height(), 1e-8);
  world->reset();
  world->set_pair_rule(cube, table, rule(ContactPolicy::cue));
  lower();
  EXPECT_LT(height(), -0.2);
}

TEST(ContactWorld, BothMoversOfABlockedPairStopTogether) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const ObjectHandle a = world->add({box_tree("a", {1, 1, 1}), at(-2, 0, 0)});
  const ObjectHandle b = world->add({box_tree("b", {1, 1, 1}), at(2, 0, 0)});
  const ObjectHandle c = world->add({box_tree("c", {1, 1, 1}), at(-4, 0, 0)});
  // a and b meet at s = 0.5; c, which follows a at its own pace, then runs into the stopped a.
  const FrameReport report = world->frame(std::array{world->move_by(a, {3, 0, 0}, {0, 0, 0}),
                                                     world->move_by(b, {-3, 0, 0}, {0, 0, 0}),
                                                     world->move_by(c, {3, 0, 0}, {0, 0, 0})});
  EXPECT_NEAR(world->actual_pose(a).p.x(), -0.5, kGap);
  EXPECT_NEAR(world->actual_pose(b).p.x(), 0.5, kGap);
  EXPECT_NEAR(world->actual_pose(c).p.x(), -1.5, 2 * kGap);
  EXPECT_EQ(report.blocked_movers, 3u);
}

TEST(ContactWorld, RegistrationOrderDoesNotShow) {
  std::array<double, 2> x{};
  for (const bool reversed : {false, true}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::advance));
    std::array<ObjectHandle, 3> h;
    const std::array<std::string, 3> names{"a", "b", "c"};
    for (int k = 0; k < 3; ++k) {
      const int i = reversed ? 2 - k : k;
      h[i] = world->add({box_tree(names[i], {1, 1, 1}), at(-2 + 2.1 * i, 0, 0)});
    }
    world->frame(std::array{world->move_by(h[0], {1.5, 0.1, 0}, {0, 0, 0.3}),
                            world->move_by(h[2], {-1.2, 0, 0}, {0.2, 0, 0}),
                            world->move_by(h[1], {0.05, 0, 0}, {0, 0, 0})});
    x[reversed] = world->actual_pose(h[0]).p.x() + 10 * world->actual_pose(h[1]).p.x() +
                  100 * world->actual_pose(h[2]).p.x();
  }
  EXPECT_EQ(x[0], x[1]);
}

TEST(ContactWorld, OverlappingStartIsReportedAndMayOnlyComeOut) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  world->add({box_tree("table", {4, 4, 1}), at(0, 0, -0.5), true});
  const ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 0.4)});
  FrameReport report = world->frame(std::array{world->move_by(cube, {0, 0, -0.1}, {0, 0, 0})});
  EXPECT_THAT(kinds(report), Contains(EventKind::penetrating_at_start));
  EXPECT_NEAR(world->actual_pose(cube).p.z(), 0.4, 1e-12);
  report = world->frame(std::array{world->move_by(cube, {0, 0, 0.3}, {0, 0, 0})});
  EXPECT_EQ(world->actual_pose(cube).p.z(), 0.4 + 0.3);
}

TEST(ContactWorld, LatchedObjectMovesWithItsCarrierAndBlocksForIt) {
  CubeOverTable scene;
  scene.world->set_default_rule(rule(ContactPolicy::advance));
  const ObjectHandle arm = scene.world->add({box_tree("arm", {0.2, 0.2, 2}), at(0, 0, 2.5 + kGap)});
  scene.world->latch(arm, scene.cube);
  const FrameReport report =
      scene.world->frame(std::array{scene.world->move_by(arm, {0, 0, -0.8}, {0, 0, 0})});
  EXPECT_LE(scene.height(), 1.1 * kGap);
  EXPECT_GT(scene.height(), 0.0);
  ASSERT_FALSE(report.events.empty());
  for (const ContactEvent& event : report.events) {
    EXPECT_TRUE(event.a == scene.table || event.b == scene.table);
    EXPECT_TRUE(event.a == scene.cube || event.b == scene.cube);
  }
  // A carried object takes no commands of its own.
  EXPECT_THAT(kinds(scene.move({0, 0, 1})), Contains(EventKind::refused));
  scene.world->unlatch(scene.cube);
  scene.world->frame(std::array{scene.world->move_by(arm, {0, 0, 0.5}, {0, 0, 0})});
  EXPECT_LE(scene.height(), 1.1 * kGap);
}

TEST(ContactWorld, LatchChainsMoveAsOneAndCyclesAreRefused) {
  const auto world = make_world();
  const ObjectHandle a = world->add({box_tree("a", {1, 1, 1}), at(0, 0, 0)});
  const ObjectHandle b = world->add({box_tree("b", {1, 1, 1}), at(2, 0, 0)});
  const ObjectHandle c = world->add({box_tree("c", {1, 1, 1}), at(4, 0, 0)});
  world->latch(a, b);
  world->latch(b, c);
  EXPECT_THROW(world->latch(c, a), InputError);
  EXPECT_THROW(world->latch(a, b), InputError);
  EXPECT_THROW(world->remove(b), InputError);
  world->frame(std::array{world->move_by(a, {0, 0, 0}, {0, 0, 90 * kDegree})});
  EXPECT_NEAR(world->actual_pose(c).p.y(), 4, 1e-12);
  EXPECT_NEAR(world->actual_pose(c).p.x(), 0, 1e-12);
  world->reset();
  EXPECT_EQ(world->actual_pose(c).p.x(), 4);
  EXPECT_THROW(world->unlatch(c), InputError);
}

// Scene 6: the carried ORU meets the gate at 18.121 deg, though at 90 deg it would be clear again.
TEST(ContactWorld, CarriedObjectIsCaughtInTheGate) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const ObjectHandle arm = world->add({box_tree("arm", {0.2, 0.2, 0.2}), at(0, 0, 2)});
  const ObjectHandle oru = world->add({box_tree("oru", {1.050, 0.919, 0.525}), at(0, 0, 0)});
  world->add({box_tree("left", {4, 0.1, 1}), at(0, 0.65, 0), true});
  world->add({box_tree("right", {4, 0.1, 1}), at(0, -0.65, 0), true});
  world->latch(arm, oru);
  world->frame(std::array{world->move_by(arm, {0, 0, 0}, {0, 0, 90 * kDegree})});
  const double closed_form = std::asin(0.6 / (std::hypot(1.050, 0.919) / 2)) - std::atan2(0.919, 1.050);
  EXPECT_NEAR(std::asin(world->actual_pose(oru).R(1, 0)), closed_form, 1e-8);
  EXPECT_NEAR(closed_form / kDegree, 18.121, 5e-4);
}

TEST(ContactWorld, SelectionTakesEffectAtTheNextFrameAndIsRecorded) {
  CubeOverTable scene;
  scene.world->frame({});
  const SelectionChange off = SelectionChange::of(scene.cube, false);
  std::thread other([&] { scene.world->select(off); });
  other.join();
  EXPECT_THAT(kinds(scene.move({0, 0, -0.8})), Not(Contains(EventKind::blocked)));
  EXPECT_NEAR(scene.height(), -0.3, 1e-15);
  scene.world->select(SelectionChange::of(scene.cube, true));
  EXPECT_THAT(kinds(scene.move({0, 0, 0})), Contains(EventKind::penetrating_at_start));
  ASSERT_EQ(scene.world->selection_record().size(), 2u);
  EXPECT_EQ(scene.world->selection_record()[0].frame, 1u);
  EXPECT_EQ(scene.world->selection_record()[0].change, off);
}

TEST(ContactWorld, ExemptPairIsNotChecked) {
  CubeOverTable scene;
  scene.world->exempt({scene.cube, scene.table, "box"});
  EXPECT_THAT(kinds(scene.move({0, 0, -0.8})), IsEmpty());
  EXPECT_NEAR(scene.height(), -0.3, 1e-15);
  EXPECT_THROW(scene.world->exempt({scene.cube, scene.table, "lid"}), InputError);
}

TEST(ContactWorld, ObjectsComeAndGoAtRunTime) {
  CubeOverTable scene;
  scene.move({0, 0, -0.2});
  const ObjectHandle lid = scene.world->add({box_tree("lid", {2, 2, 0.1}), at(0, 0, 0.2), true});
  EXPECT_THAT(kinds(scene.move({0, 0, -0.2})), Contains(EventKind::blocked));
  scene.world->remove(lid);
  EXPECT_THAT(kinds(scene.move({0, 0, -0.2})), IsEmpty());
  EXPECT_FALSE(scene.world->is_alive(lid));
  EXPECT_THROW(scene.world->remove(lid), InputError);
  const ObjectHandle another = scene.world->add({box_tree("lid", {2, 2, 0.1}), at(0, 3, 0.2), true});
  EXPECT_FALSE(another == lid);
  EXPECT_EQ(scene.world->find("lid"), another);
}

TEST(ContactWorld, BadInputIsAnErrorOrARefusalAndChangesNothing) {
  CubeOverTable scene;
  EXPECT_THROW(scene.world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 5)}), InputError);
  EXPECT_THROW(scene.world->add({nullptr, at(0, 0, 5)}), InputError);
  Pose bad = at(0, 0, 5);
  bad.R(0, 0) = kNaN;
  EXPECT_THROW(scene.world->add({box_tree("x", {1, 1, 1}), bad}), InputError);
  EXPECT_THROW(scene.world->find("x"), InputError);
  const FrameReport report = scene.move({0, 0, kInfinity});
  EXPECT_THAT(kinds(report), ElementsAre(EventKind::refused));
  EXPECT_EQ(scene.height(), 0.5);
  EXPECT_THAT(kinds(scene.world->frame(std::array{MotionCommand{ObjectHandle{77, 1}, RigidPath()}})),
              ElementsAre(EventKind::refused));
  try {
    scene.world->latch(scene.cube, scene.table);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'table'"));
  }
}

}  // namespace
}  // namespace touchstone
