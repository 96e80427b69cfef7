#include "touchstone/adapters/recorder/recorder.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <array>
#include <csignal>
#include <thread>

#include "output_fixture.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/output/output_feed.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using ::testing::HasSubstr;

void expect_same_frame(const RecordedFrame& read, const MadeFrame& made, const Recording& recording) {
  EXPECT_EQ(read.frame, made.frame);
  EXPECT_TRUE(same_bits(read.time, made.time));
  ASSERT_EQ(read.poses.size(), made.poses.size());
  for (std::size_t i = 0; i < made.poses.size(); ++i) {
    EXPECT_EQ(recording.objects[read.poses[i].object], "object " + std::to_string(made.poses[i].object.slot));
    EXPECT_TRUE(same_bits(read.poses[i].X_WO, made.poses[i].X_WO));
  }
  ASSERT_EQ(read.events.size(), made.events.size());
  for (std::size_t i = 0; i < made.events.size(); ++i) {
    const RecordedEvent& a = read.events[i];
    const ContactEvent& b = made.events[i];
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(recording.objects[a.a], "object " + std::to_string(b.a.slot));
    EXPECT_EQ(recording.objects[a.b], "object " + std::to_string(b.b.slot));
    EXPECT_EQ(a.solids, b.solids);
    EXPECT_EQ(a.part, b.part);
    EXPECT_TRUE(same_bits(a.s, b.s) && same_bits(a.geometry, b.geometry) &&
                same_bits(a.geometry_at_end, b.geometry_at_end));
  }
}

TEST(RecorderThread, ReadsBackBitForBit) {
  const TemporaryFile file("bits.csv");
  const auto frames = make_frames(500, 20, 1);
  {
    Recorder recorder(file.path(), {.when_full = WhenFull::wait});
    announce(recorder, 20);
    for (const MadeFrame& frame : frames) recorder.write(frame.view());
    recorder.close();
    EXPECT_EQ(recorder.status().delivered, 500u);
    EXPECT_EQ(recorder.status().dropped, 0u);
    EXPECT_EQ(recorder.status().errors, 0u);
  }
  const Recording recording = read_recording(file.path());
  EXPECT_TRUE(recording.is_complete);
  EXPECT_EQ(recording.lost(), 0u);
  ASSERT_EQ(recording.frames.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    expect_same_frame(recording.frames[i], frames[i], recording);
}

TEST(RecorderThread, ReplayOfARecordIsTheSameRecord) {
  const TemporaryFile first("first.csv"), second("second.csv");
  {
    Recorder recorder(first.path(), {.when_full = WhenFull::wait});
    announce(recorder, 7);
    for (const MadeFrame& frame : make_frames(200, 7, 2)) recorder.write(frame.view());
  }
  {
    Recorder recorder(second.path(), {.when_full = WhenFull::wait});
    replay(read_recording(first.path()), recorder);
  }
  EXPECT_GT(first.text().size(), 100'000u);
  EXPECT_EQ(first.text(), second.text());
}

// The same commands give the same record: what a replay of a run rests on.
TEST(RecorderThread, ARunFlownTwiceGivesTheSameRecord) {
  const TemporaryFile first("run1.csv"), second("run2.csv");
  for (const TemporaryFile* file : {&first, &second}) {
    const auto world = make_world();
    world->set_default_rule(rule(ContactPolicy::slide, 0.01));
    const ObjectHandle table = world->add({box_tree("table, \"round\"", {4, 4, 1}), at(0, 0, -0.5), true});
    const ObjectHandle cube = world->add({box_tree("cube", {1, 1, 1}), at(0, 0, 1.0)});
    Recorder recorder(file->path());
    OutputFeed feed(*world);
    feed.add_output(recorder);
    feed.show(table);
    feed.show(cube);
    for (int i = 0; i < 50; ++i) {
      const std::array commands{world->move_by(cube, {0.01, 0, -0.02}, {0, 0, 0.01})};
      feed.send(world->frame(commands), 0.01 * (i + 1));
    }
    // A bad command: an event without a second object, its figures not numbers.
    const std::array bad{world->move_by(table, {0, 0, 1}, {0, 0, 0})};
    feed.send(world->frame(bad), 0.51);
  }
  EXPECT_EQ(first.text(), second.text());
  const Recording recording = read_recording(first.path());
  EXPECT_EQ(recording.objects[0], "table, \"round\"");
  ASSERT_EQ(recording.frames.size(), 51u);
  const RecordedEvent& refused = recording.frames.back().events.at(0);
  EXPECT_EQ(refused.kind, EventKind::refused);
  EXPECT_EQ(refused.b, RecordedEvent::kNone);
  EXPECT_TRUE(std::isnan(refused.geometry.separation));
  std::size_t events = 0;
  for (const RecordedFrame& frame : recording.frames) events += frame.events.size();
  EXPECT_GT(events, 20u);
}

TEST(RecorderThread, AllocatesNothingPerFrame) {
  const TemporaryFile file("allocations.csv");
  const auto frames = make_frames(300, 10, 3);
  Recorder recorder(file.path());
  announce(recorder, 10);
  for (const MadeFrame& frame : frames) recorder.write(frame.view());
  while (recorder.status().delivered < 300) std::this_thread::yield();
  const std::size_t before = allocation_count();  // of both threads
  for (const MadeFrame& frame : frames) recorder.write(frame.view());
  while (recorder.status().delivered < 600) std::this_thread::yield();
  EXPECT_EQ(allocation_count(), before);
}

TEST(RecorderThread, FullDiskLosesFramesButNotTheRun) {
  Recorder recorder("/dev/full");
  announce(recorder, 5);
  for (const MadeFrame& frame : make_frames(2000, 5, 4)) recorder.write(frame.view());
  recorder.close();
  const OutputStatus status = recorder.status();
  EXPECT_EQ(status.offered, 2000u);
  EXPECT_EQ(status.delivered, 0u);
  expect_adds_up(status);
  EXPECT_GT(status.errors, 0u);
  EXPECT_EQ(status.last_error, ENOSPC);
}

/// The largest size a file of this process may have.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { lift(); }
  void lift() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(RecorderThread, WholeFramesOnlyWhenTheDiskFillsAndIsFreedAgain) {
  const TemporaryFile file("filled.csv");
  const auto frames = make_frames(600, 5, 5);
  Recorder recorder(file.path());
  announce(recorder, 5);
  // Writes, and waits until the last frame is through.
  const auto write = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      recorder.write(frames[i].view());
      const auto done = [&] {
        const OutputStatus s = recorder.status();
        return s.delivered + s.dropped == s.offered;
      };
      if (i + 1 == to)
        while (!done()) std::this_thread::yield();
    }
  };
  // The disk is full from some frame on, then free.
  FileSizeLimit limit(100'000);
  write(0, 400);
  EXPECT_EQ(recorder.status().last_error, EFBIG);
  limit.lift();
  write(400, 600);
  recorder.close();
  const OutputStatus status = recorder.status();
  expect_adds_up(status);
  EXPECT_GT(status.dropped, 0u);
  EXPECT_GE(status.delivered, 200u);

  // Only whole frames are there, and what is lost is said where it is missing.
  const Recording recording = read_recording(file.path());
  EXPECT_TRUE(recording.is_complete);
  EXPECT_EQ(recording.frames.size(), status.delivered);
  EXPECT_EQ(recording.lost(), status.dropped);
  std::uint64_t expected = 0;
  for (const RecordedFrame& frame : recording.frames) {
    expected += frame.lost_before;
    EXPECT_EQ(frame.frame, expected++);  // lost ones are reported where they are missing
    expect_same_frame(frame, frames[frame.frame], recording);
  }
}

TEST(RecorderThread, ClosedDescriptorIsAnErrorNotACrash) {
  const TemporaryFile file("closed.csv");
  const int descriptor = open(file.path().c_str(), O_WRONLY | O_CREAT, 0600);
  Recorder recorder(descriptor);
  ASSERT_EQ(close(descriptor), 0);
  announce(recorder, 2);
  for (const MadeFrame& frame : make_frames(50, 2, 6)) recorder.write(frame.view());
  recorder.close();
  EXPECT_EQ(recorder.status().dropped, 50u);
  EXPECT_EQ(recorder.status().last_error, EBADF);
}

TEST(RecorderThread, PipeWhoseReaderIsGone) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  close(ends[0]);
  Recorder recorder(ends[1]);
  announce(recorder, 2);
  for (const MadeFrame& frame : make_frames(50, 2, 7)) recorder.write(frame.view());
  recorder.close();
  EXPECT_EQ(recorder.status().dropped, 50u);
  EXPECT_EQ(recorder.status().last_error, EPIPE);
}

TEST(RecorderThread, PipeThatNobodyReadsDelaysNoFrame) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  Recorder recorder(ends[1], {.rows = 1024, .patience = std::chrono::milliseconds(50)});
  announce(recorder, 5);
  const auto frames = make_frames(100, 5, 8);
  // Far more than pipe, text and ring hold: were one write to wait, this would never end.
  for (int i = 0; i < 50; ++i)
    for (const MadeFrame& frame : frames) recorder.write(frame.view());
  EXPECT_GT(recorder.status().dropped, 2000u);
  const auto start = std::chrono::steady_clock::now();
  recorder.close();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_EQ(recorder.status().offered, 5000u);
  expect_adds_up(recorder.status());
  EXPECT_EQ(recorder.status().last_error, ETIMEDOUT);
  close(ends[0]);
}

TEST(RecorderThread, WaitLosesNothingThroughASmallRing) {
  const TemporaryFile file("waits.csv");
  const auto frames = make_frames(400, 30, 9);
  {
    Recorder recorder(file.path(), {.rows = 64, .when_full = WhenFull::wait});
    announce(recorder, 30);
    for (const MadeFrame& frame : frames) recorder.write(frame.view());
  }
  EXPECT_EQ(read_recording(file.path()).frames.size(), frames.size());
}

TEST(RecorderThread, DropTellsWhereFramesAreMissing) {
  const TemporaryFile file("drops.csv");
  const auto frames = make_frames(3000, 30, 10);
  OutputStatus status;
  {
    Recorder recorder(file.path(), {.rows = 64});
    announce(recorder, 30);
    for (const MadeFrame& frame : frames) recorder.write(frame.view());
    recorder.close();
    status = recorder.status();
  }
  EXPECT_GT(status.dropped, 0u);
  expect_adds_up(status);
  const Recording recording = read_recording(file.path());
  EXPECT_EQ(recording.frames.size(), status.delivered);
  EXPECT_EQ(recording.lost(), status.dropped);
  std::uint64_t expected = 0;
  for (const RecordedFrame& frame : recording.frames) {
    expected += frame.lost_before;
    EXPECT_EQ(frame.frame, expected++);
  }
}

// A frame that never fits is dropped even by one that waits.
TEST(RecorderThread, FrameLargerThanTheRingIsDropped) {
  const TemporaryFile file("large.csv");
  Recorder recorder(file.path(), {.rows = 16, .when_full = WhenFull::wait});
  for (const MadeFrame& frame : make_frames(3, 20, 11)) recorder.write(frame.view());
  recorder.close();
  EXPECT_EQ(recorder.status().dropped, 3u);
  const Recording recording = read_recording(file.path());
  EXPECT_TRUE(recording.is_complete);
  EXPECT_EQ(recording.lost_after, 3u);
}

TEST(RecorderThread, FramesAfterCloseAreCounted) {
  const TemporaryFile file("late.csv");
  Recorder recorder(file.path());
  recorder.close();
  for (const MadeFrame& frame : make_frames(3, 1, 12)) recorder.write(frame.view());
  EXPECT_EQ(recorder.status().dropped, 3u);
}

TEST(RecorderThread, ObjectsComeWhileFramesRun) {
  const TemporaryFile file("joining.csv");
  const auto frames = make_frames(200, 40, 13);
  {
    Recorder recorder(file.path(), {.when_full = WhenFull::wait});
    for (std::uint32_t i = 0; i < 200; ++i) {
      if (i % 5 == 0) recorder.add_object({{i / 5, 0}, "object " + std::to_string(i / 5)});
      MadeFrame frame = frames[i];
      frame.events.clear();
      frame.poses.resize(i / 5 + 1);
      recorder.write(frame.view());
    }
  }
  const Recording recording = read_recording(file.path());
  EXPECT_EQ(recording.objects.size(), 40u);
  EXPECT_EQ(recording.frames[199].poses.size(), 40u);
  EXPECT_EQ(recording.objects[39], "object 39");
}

TEST(Recorder, SaysWhatItCannotOpen) {
  try {
    Recorder recorder("/no/such/folder/run.csv");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/no/such/folder/run.csv"));
    EXPECT_THAT(error.what(), HasSubstr("No such file"));
  }
  EXPECT_THROW(Recorder(-1), InputError);
}

TEST(Recorder, RefusesObjectsThatDoNotFit) {
  const TemporaryFile file("refuses.csv");
  Recorder recorder(file.path(), {.rows = 4});
  announce(recorder, 3);
  EXPECT_THROW(recorder.add_object({{3, 0}, "one too many"}), InputError);
  EXPECT_THROW(recorder.add_object({{3, 0}, std::string(2001, 'x')}), InputError);
}

}  // namespace
}  // namespace touchstone
