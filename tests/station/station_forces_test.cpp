#include <gtest/gtest.h>

#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/tests/station/forces_pilot.hpp"

// The scenes with jaws, two arms and rails, flown with forces: tasks are done within their limits of force,
// what is in the way presses back, nothing merges.

namespace touchstone::station {
namespace {

/// Who exchanges an ORU.
struct OruPilot : ForcesPilot {
  using ForcesPilot::ForcesPilot;

  void take_oru(double x, double y) {
    ASSERT_TRUE(fly_to({x, y, kOver + 0.2}));
    ASSERT_TRUE(fly_to({x, y, kOver}, 0.05));
    EXPECT_FALSE(set({Kind::latch, true, Control::kAny}).done) << "with its jaws open";
    grip(1.0, 4.0);
    const ControlAnswer answer = set({Kind::latch, true, Control::kAny});
    ASSERT_TRUE(answer.done) << answer.text;
  }
  void bring_home(double x, double from_y, double to_y, std::size_t extract, std::size_t insert) {
    ASSERT_TRUE(fly_to({x, from_y, kOver + 0.4}, 0.05));
    EXPECT_TRUE(is_done(extract));
    ASSERT_TRUE(fly_to({x, to_y, kOver + 0.4}, 0.1));
    ASSERT_TRUE(fly_to({x, to_y, kOver}, 0.05));
    ASSERT_TRUE(set({Kind::release}).done);
    grip(-1.0, 4.0);
    ASSERT_TRUE(fly_to({x, to_y, kOver + 0.4}, 0.05));
    EXPECT_TRUE(is_done(insert));
    EXPECT_TRUE(is_within(insert)) << figures().largest_force;
  }
};

/// The pilot's axes are the world's.
HandInput downwards(double rate) {
  HandInput hand;
  hand.translation = {0.0, 0.0, -rate};
  return hand;
}

TEST(StationForces, TheOtcmExchangesAnOru) {
  OruPilot pilot("otcm");
  pilot.take_oru(0.0, 0.0);
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_GT(pilot.figures().largest_force, 10.0) << "jaws press";
  pilot.bring_home(0.0, 0.0, -1.1, 1, 2);
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, OneArmOfTheSpdmSteadiesWhileTheOtherExchanges) {
  OruPilot pilot("spdm");
  ASSERT_TRUE(pilot.set({Kind::tip, true, 1}).done);
  ASSERT_TRUE(pilot.fly_to({-0.9, 0.9, kOver + 0.2}));
  ASSERT_TRUE(pilot.fly_to({-0.9, 0.9, kOver}, 0.05));
  pilot.grip(1.0, 4.0);
  EXPECT_TRUE(pilot.is_done(0));
  ASSERT_TRUE(pilot.set({Kind::tip, true, 0}).done);
  pilot.take_oru(-0.9, -0.5);
  EXPECT_TRUE(pilot.is_done(1));
  pilot.bring_home(-0.9, -0.5, -1.6, 2, 3);
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

/// Rails of 1 kN against joints of 2.3 kN m at the end of a long arm: the arm gives way.
TEST(StationForces, ThePanelBendsAnArmThatIsMovedIntoIt) {
  OruPilot pilot("mobile_transporter");
  const double shoulder = pilot.joint("shoulder_pitch"), elbow = pilot.joint("elbow_pitch");
  EXPECT_FALSE(pilot.drive("rail", 3.0, 60.0));
  EXPECT_GT(pilot.figures().largest_force, 100.0);
  EXPECT_GT(std::abs(pilot.joint("shoulder_pitch") - shoulder) + std::abs(pilot.joint("elbow_pitch") - elbow),
            0.01);
  EXPECT_FALSE(pilot.is_done(0));
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, AFoldedArmGoesAlongTheTruss) {
  OruPilot pilot("mobile_transporter");
  pilot.drive("shoulder_pitch", -85.0 * kDegree, 30.0);
  pilot.drive("elbow_pitch", 170.0 * kDegree, 30.0);
  pilot.drive("rail", 3.0, 140.0);
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_TRUE(pilot.is_within(0)) << pilot.figures().largest_force;
  ASSERT_TRUE(pilot.fly_to({-3.4, -1.9, 0.78}));
  EXPECT_TRUE(pilot.is_done(1));
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, TheFixturePressesBackOnAMouthThatMissesIt) {
  OruPilot pilot("grapple");
  for (int frame = 0; frame < 150; ++frame) pilot.step(downwards(0.5));
  EXPECT_GT(pilot.figures().largest_force, 10.0);
  EXPECT_GT(pilot.blocked, 0);
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, AnOruGoesIntoItsGuideAndIsPressedByItsRim) {
  OruPilot pilot("oru_into_guide");
  ASSERT_TRUE(
      pilot.flight().ours().formation().carrier[find_object(pilot.scenes[0]->setting.scene(), "oru")] !=
      training::kNone);
  // 0.1 m beside the guide: down onto its rim.
  for (int frame = 0; frame < 100; ++frame) pilot.step(downwards(0.5));
  EXPECT_GT(pilot.figures().largest_force, 10.0);
  const double plate = 0.565;  // of the mouth over the ORU's bottom
  ASSERT_TRUE(pilot.fly_to({0.1, 0.0, 0.1 + plate}, 0.1));
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, 0.1 + plate}, 0.1));
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, plate + 0.02}, 0.05));
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, plate - 0.52}, 0.02, 90.0)) << pilot.pose_of("oru").p;
  ASSERT_TRUE(pilot.set({Kind::release}).done);
  pilot.step({});
  EXPECT_TRUE(pilot.is_done(0));
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, TheLabPressesBackOnAnElbow) {
  OruPilot pilot("elbow_over_lab");
  for (int frame = 0; frame < 200; ++frame) pilot.step(downwards(0.5));
  EXPECT_GT(pilot.figures().largest_force, 10.0);
  EXPECT_GT(pilot.pose_of("ssrms.lower_boom").p.z(), 0.0);
  EXPECT_EQ(pilot.figures().failed_steps, 0U);
  EXPECT_EQ(pilot.merged, 0);
}

TEST(StationForces, StepsThatGripAllocateNothing) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "not counted here";
  OruPilot pilot("spdm");
  pilot.take_oru(-0.9, -0.5);
  HandInput hand;
  hand.translation = {0.2, 0.3, 0.1};
  const auto fly = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) pilot.session.step(hand);
  };
  fly(20);
  const auto before = measures::thread_allocations();
  fly(100);
  EXPECT_EQ(*measures::thread_allocations() - *before, 0U);
}

TEST(StationForces, AFlightThatGripsReplaysToTheSameBits) {
  OruPilot pilot("otcm");
  pilot.take_oru(0.0, 0.0);
  ASSERT_TRUE(pilot.fly_to({0.0, 0.0, kOver + 0.2}, 0.05));
  station::Recording recording;
  recording.scene = "otcm";
  recording.rate = kRate;
  recording.inputs = pilot.inputs;
  recording.frames = pilot.session.frame();
  Session again(pilot.scenes, 0, kOurs, true);
  replay(recording, again);
  EXPECT_EQ(again.hash(), pilot.session.hash());
  Session without(pilot.scenes, 0, kOurs);
  replay(recording, without);
  EXPECT_NE(without.hash(), pilot.session.hash());
}

}  // namespace
}  // namespace touchstone::station
