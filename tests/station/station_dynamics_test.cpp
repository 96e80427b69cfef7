#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/examples/station/exchange/merge_judge.hpp"
#include "touchstone/examples/station/exchange/recording.hpp"
#include "touchstone/tests/station/station_scenes.hpp"

// Flights with forces: hands to joint rates, torque-limited joints, contact forces, proven poses.

namespace touchstone::station {
namespace {

/// Along the world's axes: the camera's right, up and backwards are them.
Control world_axes() {
  return {Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::camera)};
}

HandInput along(double x, double y, double z) {
  HandInput hand;
  hand.translation = {x, y, z};
  return hand;
}

/// The worksite with forces, and who judges what it shows.
struct Forces {
  explicit Forces(std::uint32_t methods = kOurs)
      : scenes(bundled({"worksite"})), session(scenes, 0, methods, true), judge(scenes[0]->setting) {
    session.set(world_axes());
    oru = scenes[0]->latches[0].carried;
  }
  const Flight& flight() const { return session.flight(); }
  const FlightFigures& figures() const { return session.flight().figures(); }
  Vector3 place(std::uint32_t object) const { return flight().ours().poses()[object].p; }

  void fly(const HandInput& hand, int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      session.step(hand);
      blocked += flight().methods().back().blocked;
      for (const training::ShownContact& contact :
           judge.contacts(flight().ours().poses(), flight().ours().formation()))
        ADD_FAILURE() << "frame " << session.frame() << ": "
                      << scenes[0]->setting.instance().solid_name(contact.solids.a) << " in "
                      << scenes[0]->setting.instance().solid_name(contact.solids.b);
    }
  }
  /// Over the probe, and down so far that the latch reaches.
  void grapple() {
    fly(along(0.06 / 0.37, -0.06 / 0.37, 0.0), 50);
    fly(along(0.0, 0.0, -0.5), 110);
    const ControlAnswer answer = session.set({Kind::latch, true, Control::kAny});
    ASSERT_TRUE(answer.done) << answer.text;
  }

  StationScenes scenes;
  Session session;
  training::Judge judge;
  std::uint32_t oru = 0;
  int blocked = 0;
};

TEST(StationDynamics, FreeOfContactTheArmGoesWhereItGoesWithoutForces) {
  Forces with;
  Session without(with.scenes, 0, kOurs);
  without.set(world_axes());
  const std::uint32_t hand = with.scenes[0]->hand_object();
  const auto fly = [&](int frames) {
    const Vector3 from = without.flight().ours().poses()[hand].p, from_with = with.place(hand);
    for (int frame = 0; frame < frames; ++frame) without.step(along(0.2, 0.1, 0.3));
    with.fly(along(0.2, 0.1, 0.3), frames);
    return std::pair(Vector3(without.flight().ours().poses()[hand].p - from),
                     Vector3(with.place(hand) - from_with));
  };
  fly(75);  // torques get the arm moving: it is late by some centimetres, and then as fast
  const auto [asked, done] = fly(25);
  EXPECT_NEAR(norm(asked), 0.5 * 0.37 * std::sqrt(0.14), 1e-3);
  EXPECT_LT(norm(done - asked), 0.02 * norm(asked));
  EXPECT_GT(with.figures().torque_share, 0.0);
  EXPECT_EQ(with.figures().largest_force, 0.0);
  EXPECT_EQ(with.figures().failed_steps, 0U);
}

TEST(StationDynamics, AGrappledOruIsCarriedPushesAndIsLetGo) {
  Forces forces;
  forces.grapple();
  forces.fly(along(0.0, 0.0, 0.5), 75);
  const Vector3 before = forces.place(forces.oru);
  forces.fly(along(0.0, 0.0, 0.5), 25);
  EXPECT_NEAR(forces.place(forces.oru).z() - before.z(), 0.25 * 0.37, 0.05 * 0.25 * 0.37);
  // Down again, onto the pallet: torques hold the load against it, and the page gets the name of what stops
  // it.
  forces.fly(along(0.0, 0.0, -0.5), 200);
  EXPECT_GT(forces.figures().largest_force, 100.0);
  EXPECT_LE(forces.figures().torque_share, 1.0 + 1e-9);
  EXPECT_GT(forces.blocked, 10);
  EXPECT_GT(forces.flight().guarded()->pushing().size(), 0U);
  // Grappled within its limits; what came after does not count against it.
  EXPECT_GT(forces.figures().done_at[0], 0.0);
  EXPECT_TRUE(forces.figures().is_within[0]);
  EXPECT_EQ(forces.scenes[0]->tasks[0].most_force, 450.0);
  ASSERT_TRUE(forces.session.set({Kind::release}).done);
  EXPECT_FALSE(forces.session.set({Kind::release}).done);
  forces.fly(along(0.0, 0.0, 0.5), 50);
  EXPECT_EQ(forces.figures().failed_steps, 0U);
}

TEST(StationDynamics, WhatIsPushedFloatsOff) {
  Forces forces;
  const Vector3 before = forces.place(forces.oru);
  forces.fly(along(0.06 / 0.37, -0.06 / 0.37, 0.0), 50);
  // The bore is over the probe; down to the plate and on, then aside: the bore's wall takes the probe along.
  forces.fly(along(0.0, 0.0, -0.5), 130);
  forces.fly(along(0.0, 0.4, 0.0), 150);
  EXPECT_GT(forces.figures().largest_force, 1.0);
  EXPECT_GT(forces.place(forces.oru).y() - before.y(), 0.01);
}

TEST(StationTasks, DoneBeyondTheirLimitsAreSaidToBe) {
  // A scene of one block, flown by a script.
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "touchstone_station_limits";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scene.yaml") << R"(name: block
frame_rate: 50
duration: 60
contact_gap: 1.0e-6
policy: slide
objects: [{name: a, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}]
)";
  std::ofstream(folder / "block.yaml")
      << "name: b\nscene: {file: scene.yaml}\nduration: 60\nhands: [{object: a, rates: [{time: 0}]}]\n";
  // With a task that has these limits.
  const auto load = [&](const std::string& limits) {
    std::ofstream(folder / "block.tasks.json")
        << R"([{"name": "t", "title": "t", "kind": "reach", "position": [0.1, 0, 0], "within": 0.01, "limits": )"
        << limits << "}]";
    StationScenes scenes;
    scenes.push_back(load_station_scene(folder / "block.yaml", 50.0));
    return scenes;
  };
  // The block is there after 0.26 s.
  const auto is_within = [&](const std::string& limits) {
    const StationScenes scenes = load(limits);
    Session session(scenes, 0, kOurs);
    for (int frame = 0; frame < 20; ++frame) session.step(ahead(1.0));  // there after 13 frames
    EXPECT_NEAR(session.flight().figures().done_at[0], 0.26, 1e-9);
    return session.flight().figures().is_within[0];
  };
  EXPECT_TRUE(is_within("{}"));
  EXPECT_TRUE(is_within(R"({"time": 0.3, "force": 0, "contacts": 0})"));
  EXPECT_FALSE(is_within(R"({"time": 0.2})"));
  for (const char* bad : {R"({"speed": 1})", R"({"time": -1})", R"({"force": "none"})"})
    EXPECT_THROW(load(bad), InputError) << bad;
}

TEST(StationDynamics, ABrakedJointHoldsAndOneWithoutTorqueDoesNotFollow) {
  for (const bool is_brake : {true, false}) {
    Forces forces;
    const auto joint = [&] { return forces.flight().ours().joints()[3]; };
    const double start = joint();
    Control fault{is_brake ? Kind::joint_brake : Kind::torque_loss, true, 3, 0.0};
    ASSERT_TRUE(forces.session.set(fault).done);
    ASSERT_TRUE(forces.session.set({Kind::joint_mode, true, 3}).done);
    HandInput drive;
    drive.joint = 1.0;
    forces.fly(drive, 25);
    EXPECT_LT(std::abs(joint() - start), 1e-6) << is_brake;
    fault.on = false, fault.value = 1.0;
    ASSERT_TRUE(forces.session.set(fault).done);
    forces.fly(drive, 100);
    const double before = joint();
    forces.fly(drive, 25);
    EXPECT_NEAR(joint() - before, 0.5 * 0.0698, 0.02 * 0.5 * 0.0698) << is_brake;
  }
}

TEST(StationDynamics, WhatIsSwitchedOffMeetsNothing) {
  Forces forces;
  ASSERT_TRUE(forces.session.set({Kind::select, false, forces.oru}).done);
  const Vector3 before = forces.place(forces.oru);
  forces.fly(along(0.0, 0.0, -0.5), 150);
  EXPECT_EQ(forces.figures().largest_force, 0.0);
  EXPECT_EQ(forces.place(forces.oru), before);
}

TEST(StationDynamics, PoliciesApplyToForcesToo) {
  Forces forces;
  ASSERT_TRUE(forces.session.set({Kind::policy, true, static_cast<std::uint32_t>(ContactPolicy::hold)}).done);
  const Vector3 before = forces.place(forces.oru);
  forces.fly(along(0.0, 0.0, -0.5), 150);
  EXPECT_GT(forces.blocked, 10);
  EXPECT_EQ(forces.place(forces.oru), before);  // held at the contact, no force
  ASSERT_TRUE(forces.session.set({Kind::policy, true, kPush}).done);
  forces.fly(along(0.0, 0.0, -0.5), 50);
  EXPECT_GT(forces.figures().largest_force, 1.0);
}

TEST(StationDynamics, IsRefusedWhereTheSceneHasNone) {
  StationScenes scenes;
  scenes.push_back(load_station_scene(TRAINING_SCRIPTS "/03_oru_by_arm_slide.yaml", 50.0));
  Session session(scenes, 0, kOurs, true);
  EXPECT_FALSE(session.flight().state().dynamics);
  EXPECT_EQ(session.set({Kind::dynamics, true}).text, "this scene has no dynamics");
  EXPECT_FALSE(session.set({Kind::torque_loss, true, 3, 0.5}).done);
  EXPECT_FALSE(session.set({Kind::policy, true, kPush}).done);
}

TEST(StationDynamics, AFlightReplaysToTheSameBitsThroughItsText) {
  // A flight with forces, a latch and a fault, recorded as it goes.
  const StationScenes scenes = bundled({"worksite"});
  Session session(scenes, 0);
  Recorder recorder(scenes, {scenes[0]->name, 50.0, kAllMethods, {}, 0, {}});
  const auto set = [&](const Control& control) {
    recorder.offer({session.frame(), control});
    EXPECT_TRUE(session.set(control).done);
  };
  for (std::uint64_t frame = 0; frame < 240; ++frame) {
    if (frame == 5) set({Kind::dynamics, true});
    if (frame == 5) set(world_axes());
    if (frame == 165) set({Kind::latch, true, Control::kAny});
    if (frame == 180) set({Kind::torque_loss, true, 2, 0.4});
    const HandInput hand = frame < 55    ? along(0.06 / 0.37, -0.06 / 0.37, 0.0)
                           : frame < 165 ? along(0.0, 0.0, -0.5)
                                         : along(0.1, 0.5, 0.4);
    recorder.offer({session.frame(), hand});
    session.step(hand);
    recorder.work();
  }
  recorder.end(session.frame(), session.hash());
  // Its text replays to the same hash.
  std::istringstream text(recorder.kept());
  const Recording recording = read_recording(text, "text", scenes);
  Session again(scenes, 0);
  replay(recording, again);
  EXPECT_TRUE(again.flight().state().dynamics);
  EXPECT_EQ(hash_text(again.hash()), recording.hash);
  // Without the fault it does not.
  Session other(scenes, 0);
  Recording without = recording;
  std::erase_if(without.inputs, [](const RecordedInput& input) {
    const auto* control = std::get_if<Control>(&input.input);
    return control != nullptr && control->kind == Kind::torque_loss;
  });
  replay(without, other);
  EXPECT_NE(hash_text(other.hash()), recording.hash);
}

TEST(StationDynamics, StepsAllocateNothing) {
  if (!measures::thread_allocations()) GTEST_SKIP() << "not counted here";
  Forces forces;
  forces.grapple();
  const auto steps = [&](const HandInput& hand, int frames) {
    const auto before = measures::thread_allocations();
    for (int frame = 0; frame < frames; ++frame) forces.session.step(hand);
    return *measures::thread_allocations() - *before;
  };
  steps(along(0.0, 0.0, 0.5), 10);
  steps(along(0.0, 0.0, -0.5), 60);
  EXPECT_EQ(steps(along(0.0, 0.1, -0.5), 100), 0U);
}

}  // namespace
}  // namespace touchstone::station
