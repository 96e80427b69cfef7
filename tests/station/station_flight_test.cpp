#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/server/loop.hpp"
#include "touchstone/tests/station/station_scenes.hpp"

// The station's decisions from inputs, without sockets or a clock.

namespace touchstone::station {
namespace {

/// Some hand of which no two seconds are alike.
HandInput wandering(std::uint64_t frame) {
  const double t = static_cast<double>(frame % 97) / 97.0;
  HandInput hand;
  hand.translation = {0.3 + 0.4 * t, 0.5 - t, 0.2 * t};
  hand.rotation = {0.1 * t, 0.0, 0.3 - 0.4 * t};
  return hand;
}

struct Flown {
  std::string recording;
  std::string hash;
};

/// Flies with changing hands and all kinds of controls, through the recorder.
Flown fly_and_record(const StationScenes& scenes) {
  Session session(scenes, 0);
  Recorder recorder(scenes, {scenes[0]->name, 50.0, kAllMethods, {}, 0, {}});
  const auto set = [&](const Control& control) {
    recorder.offer({session.frame(), control});
    session.set(control);
  };
  for (std::uint64_t frame = 0; frame < 150; ++frame) {
    if (frame == 20) set({Control::Kind::vernier, true});
    if (frame == 40) set({Control::Kind::vernier, false});
    if (frame == 60)
      set({Control::Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::base)});
    if (frame == 80) set({Control::Kind::joint_brake, true, 3});
    if (frame == 100) set({Control::Kind::scene, true, 1});
    if (frame == 130) set({Control::Kind::reset});
    recorder.offer({session.frame(), wandering(frame)});
    session.step(wandering(frame));
    recorder.work();
  }
  recorder.end(session.frame(), session.hash());
  return {recorder.kept(), hash_text(session.hash())};
}

TEST(StationReplay, GivesTheSameBitsOfAllPosesThroughTheRecordingsText) {
  const StationScenes scenes = bundled({"grapple", "oru_into_guide"});
  const Flown flown = fly_and_record(scenes);
  std::istringstream in(flown.recording);
  const Recording recording = read_recording(in, "flight", scenes);
  EXPECT_EQ(recording.frames, 150U);
  EXPECT_EQ(recording.hash, flown.hash);
  Session again(scenes, find_scene(scenes, recording.scene), recording.methods);
  replay(recording, again);
  EXPECT_EQ(hash_text(again.hash()), flown.hash);
}

TEST(StationReplay, OfAnInputThatDiffersByABillionthHasOtherBits) {
  const StationScenes scenes = bundled({"grapple"});
  Session first(scenes, 0, kOurs), second(scenes, 0, kOurs);
  for (int frame = 0; frame < 10; ++frame) {
    first.step(ahead(0.5));
    second.step(ahead(frame == 5 ? 0.5 + 1e-9 : 0.5));
  }
  EXPECT_NE(first.hash(), second.hash());
}

TEST(StationReplay, RefusesLinesThatAreNoInputsAndSaysWhere) {
  const StationScenes scenes = bundled({"grapple"});
  const std::string header = "{\"station\":1,\"scene\":\"grapple\",\"rate_hz\":50,\"methods\":15}\n";
  for (const char* line : {"no JSON", "{\"frame\":1}", "{\"frame\":1,\"control\":\"fly\"}", "[1]",
                           "{\"frame\":1,\"translation\":[0,0],\"rotation\":[0,0,0],\"joint\":0}"}) {
    std::istringstream in(header + line + "\n");
    try {
      read_recording(in, "file", scenes);
      ADD_FAILURE() << line;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("file:2: ", 0), 0U) << error.what();
    }
  }
}

/// The hand goes straight on for a time; returns `exact`'s verdict on each method.
JudgeFigures judged_after(const StationScenes& scenes, const HandInput& hand, int frames) {
  Session session(scenes, 0);
  MergeJudge judge(scenes);
  for (int frame = 0; frame < frames; ++frame) {
    session.step(hand);
    judge.offer(session);
    judge.work();
  }
  EXPECT_EQ(judge.passed_by(), 0U);
  return judge.take();
}

TEST(StationExperiment, OursShowsNoMergedFrameWhereNoCheckAndFigure1Merge) {
  const StationScenes scenes = bundled({"grapple"});
  // 90 mm off its axis the mouth's rim meets the probe's stem, then the plate, at up to 0.37 m/s.
  const JudgeFigures judged = judged_after(scenes, ahead(1.0), 150);
  const auto& none = judged.methods[0];
  const auto& late = judged.methods[1];
  const auto& ours = judged.methods[3];
  EXPECT_GT(none.merged, 50U);
  EXPECT_GT(none.depth_worst, 0.1);
  EXPECT_GT(late.merged, 50U);
  // The bore's facet is 100 mm from its axis, the stem's face 19 mm from its own: 9 mm into each other.
  EXPECT_NEAR(late.depth_worst, 0.009, 1e-6);
  EXPECT_LT(late.depth_worst, none.depth_worst);
  EXPECT_EQ(ours.judged, 150U);
  EXPECT_EQ(ours.merged, 0U);
}

TEST(StationExperiment, AnElbowOutOfThePictureMergesWithinTenSeconds) {
  const StationScenes scenes = bundled({"elbow_over_lab"});
  // The hand goes ahead, down beside the Lab's end, as who opens the scene and holds the first key.
  const JudgeFigures judged = judged_after(scenes, ahead(1.0), 500);
  EXPECT_GT(judged.methods[0].merged, 250U);
  EXPECT_GT(judged.methods[1].merged, 250U);
  EXPECT_GT(judged.methods[1].depth_worst, 0.005);
  EXPECT_EQ(judged.methods[3].merged, 0U);
}

TEST(StationExperiment, MethodsThatAreSwitchedOffAreNotFlown) {
  const StationScenes scenes = bundled({"grapple"});
  Session session(scenes, 0);
  EXPECT_EQ(session.flight().methods().size(), kMethods);
  EXPECT_TRUE(session.set({Control::Kind::methods, true, 1U}).done);
  ASSERT_EQ(session.flight().methods().size(), 2U);
  EXPECT_EQ(session.flight().methods()[0].kind, MethodKind::unchecked);
  EXPECT_EQ(session.flight().methods()[1].kind, MethodKind::ours);
}

TEST(StationHand, BrakesHoldAndJointModeMovesOneJointAlone) {
  const StationScenes scenes = bundled({"worksite"});
  Session session(scenes, 0, kOurs);
  const std::vector<double> start(session.flight().ours().joints().begin(),
                                  session.flight().ours().joints().end());
  session.set({Control::Kind::brakes, true});
  for (int frame = 0; frame < 5; ++frame) session.step(ahead(1.0));
  EXPECT_TRUE(std::equal(start.begin(), start.end(), session.flight().ours().joints().begin()));
  session.set({Control::Kind::brakes, false});
  session.set({Control::Kind::joint_mode, true, 2});
  HandInput hand;
  hand.joint = 1.0;
  for (int frame = 0; frame < 5; ++frame) session.step(hand);
  for (std::size_t i = 0; i < start.size(); ++i)
    EXPECT_NEAR(session.flight().ours().joints()[i] - start[i], i == 2 ? 5 * 0.02 * 0.0698 : 0.0, 1e-4) << i;
}

TEST(StationHand, FollowsTheFrameOfCommand) {
  const StationScenes scenes = bundled({"worksite"});
  const std::uint32_t hand = scenes[0]->hand_object();
  const auto moved = [&](const Control& control) {
    Session session(scenes, 0, kOurs);
    const Pose before = session.flight().ours().poses()[hand];
    session.set(control);
    for (int frame = 0; frame < 20; ++frame) session.step(ahead(0.2));
    return Vector3(session.flight().ours().poses()[hand].p - before.p);
  };
  const double way = 20 * 0.02 * 0.2 * 0.37;
  const Control tip{Control::Kind::frame_of_command, true,
                    static_cast<std::uint32_t>(CommandFrame::end_effector)};
  EXPECT_LT(norm(moved(tip) - Vector3(0.0, 0.0, -way)), 1e-6);  // out of the mouth: down
  Control camera{Control::Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::camera)};
  const double half = std::sqrt(0.5);
  camera.attitude = {0.0, 0.0, half, half};  // its right is the world's y
  EXPECT_LT(norm(moved(camera) - Vector3(0.0, way, 0.0)), 1e-6);
}

TEST(StationLatch, ClosesWithinReachAloneAndCarriesInAllMethods) {
  const StationScenes scenes = bundled({"worksite"});
  Session session(scenes, 0);
  EXPECT_FALSE(session.set({Control::Kind::latch, true, Control::kAny}).done);
  HandInput aside;
  // The mouth is above the probe but for 60 mm along each axis of the pallet: to its axis, then down.
  session.set({Control::Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::camera)});
  aside.translation = {0.06 / (0.37 * 1.0), -0.06 / (0.37 * 1.0), 0.0};
  for (int frame = 0; frame < 50; ++frame) session.step(aside);
  HandInput down;
  down.translation = {0.0, 0.0, -0.5};
  for (int frame = 0; frame < 110; ++frame) session.step(down);
  const ControlAnswer answer = session.set({Control::Kind::latch, true, Control::kAny});
  EXPECT_TRUE(answer.done) << answer.text;
  EXPECT_EQ(answer.text, "ssrms.tip_lee carries oru");
  const auto oru = scenes[0]->latches[0].carried;
  const double before = session.flight().ours().poses()[oru].p.z();
  EXPECT_EQ(session.flight().figures().done_at[0], 0.0);
  HandInput up;
  up.translation = {0.0, 0.0, 0.5};
  for (int frame = 0; frame < 50; ++frame) session.step(up);
  EXPECT_NEAR(session.flight().ours().poses()[oru].p.z() - before, 0.5 * 0.37, 0.01);
  // Goals: it is grappled since the first frame after the latch, and not yet in its guide.
  ASSERT_EQ(scenes[0]->tasks.size(), 2U);
  EXPECT_NEAR(session.flight().figures().done_at[0], 161 * 0.02, 1e-9);
  EXPECT_EQ(session.flight().figures().done_at[1], 0.0);
  EXPECT_TRUE(session.set({Control::Kind::release}).done);
  EXPECT_FALSE(session.set({Control::Kind::release}).done);
}

/// Two blocks that a script latches one way and then the other, under a title that is no UTF-8.
StationScenes two_blocks() {
  // A scene of two blocks that nearly touch.
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) /
      ("touchstone_station_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "blocks_scene.yaml") << R"(name: blocks
frame_rate: 50
duration: 60
contact_gap: 1.0e-6
policy: slide
objects:
  - {name: a, pose: {position: [0, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
  - {name: b, pose: {position: [1.01, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
)";
  // Its script: a name with a byte that is no UTF-8, and latches in both directions.
  std::ofstream(folder / "blocks.yaml") << "name: MY \xff OWN\n"
                                        << R"(scene: {file: blocks_scene.yaml}
policy: slide
duration: 60
hands:
  - {object: a, rates: [{time: 0}]}
actions:
  - {time: 1, latch: {carrier: a, carried: b}}
  - {time: 2, release: b}
  - {time: 3, latch: {carrier: b, carried: a}}
)";
  StationScenes out;
  out.push_back(load_station_scene((folder / "blocks.yaml").string(), 50.0));
  return out;
}

TEST(StationLatch, ACycleIsRefusedAndChangesNoMethod) {
  const StationScenes scenes = two_blocks();
  Session session(scenes, 0), with_one(scenes, 0);
  ASSERT_TRUE(session.set({Control::Kind::latch, true, 1}).done);
  ASSERT_TRUE(with_one.set({Control::Kind::latch, true, 1}).done);
  const ControlAnswer answer = session.set({Control::Kind::latch, true, 0});
  EXPECT_FALSE(answer.done);
  EXPECT_EQ(answer.text, "a carries b: a latch would close a cycle");
  for (int frame = 0; frame < 20; ++frame) session.step(ahead(0.2)), with_one.step(ahead(0.2));
  EXPECT_EQ(session.hash(), with_one.hash());
}

TEST(StationScenes, ATitleThatIsNoUtf8IsSentWithAReplacement) {
  const std::string text = scene_json(*two_blocks()[0]);
  EXPECT_NE(text.find("MY \xef\xbf\xbd OWN"), std::string::npos) << text;
}

TEST(StationControls, ThatNameWhatIsNotThereChangeNothing) {
  const StationScenes scenes = bundled({"grapple"});
  Session session(scenes, 0, kOurs), untouched(scenes, 0, kOurs);
  for (const Control& control :
       {Control{Control::Kind::select, true, 999}, Control{Control::Kind::scene, true, 7},
        Control{Control::Kind::joint_mode, true, 99}, Control{Control::Kind::policy, true, 17},
        Control{Control::Kind::late_report, true, 0, -1.0}, Control{Control::Kind::joint_brake, true, 40}})
    EXPECT_FALSE(session.set(control).done);
  session.step(ahead(0.5));
  untouched.step(ahead(0.5));
  EXPECT_EQ(session.hash(), untouched.hash());
}

TEST(StationScenes, StartWithNothingMerged) {
  const StationScenes scenes = bundled({"worksite", "grapple", "oru_into_guide", "elbow_over_lab", "otcm",
                                        "spdm", "mobile_transporter", "walk_off", "walk_loaded"});
  for (const auto& scene : scenes) {
    const training::Judge judge(scene->setting);
    Flight flight(*scene, kOurs);
    for (const training::ShownContact& contact :
         judge.contacts(flight.ours().poses(), flight.ours().formation()))
      ADD_FAILURE() << scene->name << ": " << scene->setting.instance().solid_name(contact.solids.a)
                    << " and " << scene->setting.instance().solid_name(contact.solids.b) << " "
                    << contact.separation;
  }
}

/// The loop, its exchange and who works for it, without threads.
struct Bench {
  explicit Bench(StationScenes given, std::uint32_t methods = kAllMethods)
      : scenes(std::move(given)),
        session(scenes, 0, methods),
        exchange(most_frame_bytes(scenes)),
        judge(scenes),
        recorder(scenes, {scenes[0]->name, 50.0, methods, {}, 0, {}}),
        loop(session, exchange, judge, &recorder) {}

  void hold(const HandInput& hand) {
    exchange.hand.back() = {hand, {1, ++number, 1000.0 * number, station_us()}};
    exchange.hand.publish();
  }

  StationScenes scenes;
  Session session;
  Exchange exchange;
  MergeJudge judge;
  Recorder recorder;
  StationLoop loop;
  std::uint32_t number = 0;
};

TEST(StationLoop, AllocatesNothingOnceWarmInOneStepOrAnother) {
  Bench bench(bundled({"worksite"}), 1U | 2U | kOurs);
  const auto fly = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      bench.hold(wandering(static_cast<std::uint64_t>(frame)));
      bench.loop.step();
    }
  };
  fly(20);
  const std::uint64_t before = bench.exchange.figures.allocations.load();
  fly(300);  // through contacts, and with nobody at the other end of any queue
  EXPECT_EQ(bench.exchange.figures.allocations.load() - before, 0U);
  EXPECT_EQ(bench.session.frame(), 320U);
  EXPECT_GT(bench.exchange.figures.not_judged.load(), 0U);
}

TEST(StationLoop, LetsGoWhereThePilotIsNotHeardOf) {
  Bench bench(bundled({"worksite"}), kOurs);
  bench.exchange.hand.back() = {ahead(1.0), {1, 1, 0.0, station_us() - 2.0 * kLetGoAfter}};
  bench.exchange.hand.publish();
  const Pose before = bench.session.flight().ours().poses()[bench.scenes[0]->hand_object()];
  bench.loop.step();
  EXPECT_EQ(bench.session.flight().ours().poses()[bench.scenes[0]->hand_object()].p, before.p);
}

TEST(StationLoop, RecordsWhatItObeyedSoThatItsFlightReplays) {
  Bench bench(bundled({"grapple", "oru_into_guide"}));
  for (int frame = 0; frame < 60; ++frame) {
    if (frame % 7 == 0) bench.hold(wandering(static_cast<std::uint64_t>(frame)));
    if (frame == 30) bench.exchange.controls.push({Control::Kind::scene, true, 1});
    bench.loop.step();
    bench.recorder.work();
  }
  bench.recorder.end(bench.session.frame(), bench.session.hash());
  std::istringstream in(bench.recorder.kept());
  const Recording recording = read_recording(in, "flight", bench.scenes);
  Session again(bench.scenes, 0);
  replay(recording, again);
  EXPECT_EQ(hash_text(again.hash()), recording.hash);
}

template <class T>
T at(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  T out;
  std::memcpy(&out, bytes.data() + offset, sizeof(T));
  return out;
}

TEST(StationFrame, IsWrittenAsTheProtocolSays) {
  Bench bench(bundled({"grapple"}));
  bench.hold(ahead(1.0));
  for (int frame = 0; frame < 120; ++frame) {
    bench.hold(ahead(1.0));
    bench.loop.step();
    bench.judge.work();
  }
  ASSERT_TRUE(bench.exchange.frame.take());
  const std::vector<std::uint8_t>& bytes = bench.exchange.frame.front();
  const auto objects = static_cast<std::uint32_t>(bench.scenes[0]->setting.object_count());
  EXPECT_EQ(at<std::uint32_t>(bytes, 0), 0x31465354U);
  EXPECT_EQ(at<std::uint64_t>(bytes, 8), 120U);
  EXPECT_DOUBLE_EQ(at<double>(bytes, 16), 2.4);
  EXPECT_DOUBLE_EQ(at<double>(bytes, 24), 121000.0);
  EXPECT_EQ(at<std::uint32_t>(bytes, 68), 121U);
  EXPECT_EQ(at<std::uint32_t>(bytes, 72), objects);
  EXPECT_EQ(at<std::uint16_t>(bytes, 76), 4);
  EXPECT_EQ(at<std::uint16_t>(bytes, 78), 7);
  const auto contacts = at<std::uint32_t>(bytes, 80), distances = at<std::uint32_t>(bytes, 84);
  EXPECT_GT(contacts, 0U);
  EXPECT_GT(distances, 0U);
  EXPECT_EQ(at<std::uint32_t>(bytes, 108), bytes.size());
  EXPECT_EQ(bytes.size(), 128U + 4 * 64 + 5 * objects * 32 + 7 * 16 + contacts * 64 + distances * 48);
  // Ours: blocked, by solids of the arm and the fixture, never merged; no check: merged.
  EXPECT_EQ(at<std::uint16_t>(bytes, 128), 0);
  EXPECT_GT(at<double>(bytes, 128 + 16), 0.0);
  const std::size_t ours = 128 + 3 * 64;
  EXPECT_EQ(at<std::uint16_t>(bytes, ours), 3);
  EXPECT_EQ(at<std::uint16_t>(bytes, ours + 2) & 1U, 1U);
  EXPECT_EQ(at<std::uint32_t>(bytes, ours + 4), 0U);
  EXPECT_GE(at<std::int32_t>(bytes, ours + 40), 0);
  // The hand's position, of ours.
  const std::size_t pose = 128 + 4 * 64 + (3 * objects + bench.scenes[0]->hand_object()) * 32;
  const Vector3& p = bench.session.flight().ours().poses()[bench.scenes[0]->hand_object()].p;
  for (int i = 0; i < 3; ++i)
    EXPECT_FLOAT_EQ(at<float>(bytes, pose + 4 * static_cast<std::size_t>(i)), static_cast<float>(p[i]));
  // Of a contact: a unit normal.
  const std::size_t contact = 128 + 4 * 64 + 5 * objects * 32 + 7 * 16;
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) square += std::pow(at<float>(bytes, contact + 28 + 4 * i), 2);
  EXPECT_NEAR(square, 1.0, 1e-5);
}

TEST(StationExchange, LatestGivesTheNewestWholeValueAcrossThreads) {
  struct Value {
    std::uint64_t a = 0, b = 0;
  };
  Latest<Value> latest;
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      latest.back() = {i, ~i};
      latest.publish();
    }
  });
  std::uint64_t seen = 0;
  while (seen < kLast) {
    if (!latest.take()) continue;
    ASSERT_EQ(latest.front().b, ~latest.front().a);
    ASSERT_GT(latest.front().a, seen);
    seen = latest.front().a;
  }
  writer.join();
}

TEST(StationExchange, RingRefusesWhatFindsNoRoomAndKeepsTheOrder) {
  Ring<int> ring(3);
  EXPECT_EQ(ring.front(), nullptr);
  for (const int value : {1, 2, 3}) EXPECT_TRUE(ring.push(value));
  EXPECT_FALSE(ring.push(4));
  for (const int value : {1, 2, 3}) {
    ASSERT_NE(ring.front(), nullptr);
    EXPECT_EQ(*ring.front(), value);
    ring.pop();
  }
  EXPECT_EQ(ring.front(), nullptr);
  EXPECT_TRUE(ring.push(5));
}

}  // namespace
}  // namespace touchstone::station
