#include <gmock/gmock.h>

#include <array>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

// A gripper: a wrist that carries a 1 m payload at the origin, and two jaws 0.1 m thick whose inner faces are
// 10 mm off it.
struct Gripper {
  std::unique_ptr<ContactWorld> world = make_world();
  ObjectHandle wrist = world->add({box_tree("wrist", {1, 1, 1}), at(0, 0, 5)});
  ObjectHandle payload = world->add({box_tree("payload", {1, 1, 1}), at(0, 0, 0)});
  ObjectHandle left = world->add({box_tree("left", {0.1, 1, 1}), at(-0.56, 0, 0)});
  ObjectHandle right = world->add({box_tree("right", {0.1, 1, 1}), at(0.56, 0, 0)});

  Gripper() { world->set_default_rule(rule(ContactPolicy::advance)); }
  void grip() { world->latch(wrist, payload, {{left, payload}, {payload, right}}); }
  FrameReport move(ObjectHandle object, double x) {
    return world->frame(std::array{world->move_by(object, {x, 0, 0}, {0, 0, 0})});
  }
  double x_of(ObjectHandle object) const { return world->actual_pose(object).p.x(); }
};

TEST(Exemption, BothJawsHoldTheLatchedPayloadAndNobodyElsePassesIt) {
  Gripper scene;
  const ObjectHandle other = scene.world->add({box_tree("other", {0.1, 0.1, 0.1}), at(0.9, 0, 0)});
  scene.grip();
  scene.move(scene.left, 0.02);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.left), -0.54);
  scene.move(scene.right, -0.02);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.54);
  scene.world->set_pair_rule(other, scene.right, rule(ContactPolicy::cue));
  scene.move(other, -1);
  EXPECT_NEAR(scene.x_of(other), 0.55, 2 * kGap);
}

// With an exemption that outlived the latch the jaw went to -0.44 m, through what was let go.
TEST(Exemption, JawDoesNotPassThroughTheReleasedPayload) {
  Gripper scene;
  scene.grip();
  EXPECT_THAT(kinds(scene.world->frame({})), IsEmpty());
  scene.world->unlatch(scene.payload);
  EXPECT_THAT(kinds(scene.move(scene.right, -1)), Contains(EventKind::blocked));
  EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
}

TEST(Exemption, OverlapAtReleaseIsReportedAndGrowsNoDeeper) {
  Gripper scene;
  scene.grip();
  scene.move(scene.right, -0.03);  // 20 mm into the payload
  scene.world->unlatch(scene.payload);
  EXPECT_THAT(kinds(scene.world->frame({})), Contains(EventKind::penetrating_at_start));
  scene.move(scene.right, -0.01);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.53);
  scene.move(scene.right, 0.01);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.54);
  scene.move(scene.right, 0.06);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.60);
  scene.move(scene.right, -1);
  EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
}

TEST(Exemption, WhatALatchAllowsEndsWithResetToo) {
  Gripper scene;
  scene.grip();
  scene.world->reset();
  scene.move(scene.right, -1);
  EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
}

// A later latch brings its own allowed pairs and none of those before it.
TEST(Exemption, EachLatchAllowsItsOwn) {
  Gripper scene;
  scene.grip();
  scene.world->unlatch(scene.payload);
  scene.world->latch(scene.wrist, scene.payload, {{scene.left, scene.payload}});
  scene.move(scene.right, -1);
  EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
  scene.move(scene.left, 2);
  EXPECT_NEAR(scene.x_of(scene.left), scene.x_of(scene.right) - 0.1, 2 * kGap);
}

TEST(Exemption, LatchThatIsRefusedAllowsNothing) {
  Gripper scene;
  EXPECT_THROW(scene.world->latch(scene.wrist, scene.payload,
                                  {{scene.left, scene.payload}, {scene.right, scene.payload, "lid"}}),
               InputError);
  EXPECT_THROW(scene.world->latch(scene.wrist, scene.payload, {{scene.left, ObjectHandle{}}}), InputError);
  EXPECT_THROW(scene.world->latch(scene.wrist, scene.payload, {{scene.left, scene.left}}), InputError);
  EXPECT_THROW(scene.world->latch(scene.payload, scene.payload, {{scene.left, scene.payload}}), InputError);
  EXPECT_THROW(scene.world->unlatch(scene.payload), InputError);
  scene.move(scene.left, 1);
  EXPECT_NEAR(scene.x_of(scene.left), -0.55, 2 * kGap);
}

TEST(Exemption, IsTakenBackInEitherOrder) {
  Gripper scene;
  scene.world->exempt({scene.right, scene.payload});
  scene.world->exempt({scene.payload, scene.right});  // twice is as once
  scene.move(scene.right, -0.03);
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.53);
  scene.world->unexempt({scene.payload, scene.right});
  EXPECT_THAT(kinds(scene.move(scene.right, -0.01)), Contains(EventKind::penetrating_at_start));
  EXPECT_DOUBLE_EQ(scene.x_of(scene.right), 0.53);
  scene.move(scene.right, 0.07);
  scene.move(scene.right, -1);
  EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
}

TEST(Exemption, IsTakenBackByTheNamesThatMadeItAndNoOther) {
  Gripper scene;
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload}), InputError);
  scene.world->exempt({scene.right, scene.payload, "box"});
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload}), InputError);
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload, "lid"}), InputError);
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload, "", "box"}), InputError);
  EXPECT_NO_THROW(scene.world->unexempt({scene.payload, scene.right, "", "box"}));
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload, "box"}), InputError);
}

// exempt() holds whatever latches come and go, and unexempt() does not end a latch's exemption.
TEST(Exemption, ThoseOfTheUserAndOfALatchAreKeptApart) {
  Gripper scene;
  scene.grip();
  EXPECT_THROW(scene.world->unexempt({scene.right, scene.payload}), InputError);
  scene.world->exempt({scene.right, scene.payload});
  scene.world->unlatch(scene.payload);
  EXPECT_THAT(kinds(scene.move(scene.right, -0.5)), Not(Contains(EventKind::blocked)));
  scene.grip();
  scene.world->unexempt({scene.right, scene.payload});
  EXPECT_THAT(kinds(scene.world->frame({})), IsEmpty());
}

TEST(Exemption, EndsWithItsObjects) {
  for (const bool by_latch : {false, true}) {
    Gripper scene;
    if (by_latch) scene.grip();
    if (!by_latch) scene.world->exempt({scene.right, scene.payload});
    const ObjectHandle old = scene.right;
    scene.world->remove(old);
    scene.right = scene.world->add({box_tree("next", {0.1, 1, 1}), at(0.56, 0, 0)});
    ASSERT_EQ(scene.right.slot, old.slot);
    scene.move(scene.right, -1);
    EXPECT_NEAR(scene.x_of(scene.right), 0.55, 2 * kGap);
    EXPECT_THROW(scene.world->unexempt({old, scene.payload}), InputError);
  }
}

// Of a tree of hexahedra only the one that is named passes.
TEST(Exemption, LatchMayAllowOneHexahedronOfAnObject) {
  const auto world = make_world();
  world->set_default_rule(rule(ContactPolicy::advance));
  const auto jaw_tree = std::make_shared<HexahedronTree>(
      std::vector<PlacedHexahedron>{{"pad", Hexahedron::from_size({0.1, 1, 1}), at(0, 0, 0)},
                                    {"bone", Hexahedron::from_size({0.1, 1, 1}), at(0.1, 0, 0)}},
      "jaw");
  const ObjectHandle wrist = world->add({box_tree("wrist", {1, 1, 1}), at(0, 0, 5)});
  const ObjectHandle payload = world->add({box_tree("payload", {1, 1, 1}), at(0, 0, 0)});
  const ObjectHandle jaw = world->add({jaw_tree, at(0.6, 0, 0)});
  world->latch(wrist, payload, {{jaw, payload, "pad"}});
  world->frame(std::array{world->move_by(jaw, {-1, 0, 0}, {0, 0, 0})});
  EXPECT_NEAR(world->actual_pose(jaw).p.x(), 0.45, 2 * kGap);  // the bone's face is at 0.5
}

}  // namespace
}  // namespace touchstone
