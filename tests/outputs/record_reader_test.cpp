#include <gmock/gmock.h>

#include "output_fixture.hpp"
#include "touchstone/adapters/recorder/recorder.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/refusal.hpp"

namespace touchstone {
namespace {

using ::testing::HasSubstr;

std::string made_record() {
  const TemporaryFile file("made.csv");
  {
    Recorder recorder(file.path());
    recorder.add_object({{0, 0}, "two\nlines"});
    recorder.add_object({{1, 0}, "plain"});
    for (const MadeFrame& frame : make_frames(5, 2, 20)) recorder.write(frame.view());
  }
  return file.text();
}

std::string message_of(const std::string& text) {
  const TemporaryFile file("bad.csv");
  file.write(text);
  return refusal_of([&] { read_recording(file.path()); });
}

TEST(RecordReader, CutOffAnywhereGivesTheWholeFrames) {
  const std::string text = made_record();
  const TemporaryFile file("cut.csv");
  std::size_t last = 0;
  for (std::size_t bytes = text.find('\n') + 1; bytes < text.size(); bytes += 29) {
    file.write(text.substr(0, bytes));
    const Recording recording = read_recording(file.path());
    EXPECT_FALSE(recording.is_complete);
    EXPECT_GE(recording.frames.size(), last);
    last = recording.frames.size();
    for (const RecordedFrame& frame : recording.frames) {
      EXPECT_EQ(frame.poses.size(), 2u);
      EXPECT_EQ(frame.events.size(), frame.frame % 3);
    }
  }
  EXPECT_EQ(last, 5u);
  file.write(text);
  EXPECT_TRUE(read_recording(file.path()).is_complete);
  EXPECT_EQ(read_recording(file.path()).objects.at(0), "two\nlines");
}

TEST(RecordReader, KnowsEveryKindOfEvent) {
  const TemporaryFile file("kinds.csv");
  constexpr int kKinds = static_cast<int>(EventKind::at_limit) + 1;
  {
    Recorder recorder(file.path());
    recorder.add_object({{0, 0}, "a"});
    MadeFrame made = make_frames(1, 1, 20)[0];
    for (int i = 0; i < kKinds; ++i)
      made.events.push_back(
          {static_cast<EventKind>(i), {0, 0}, {}, {}, 0, zero_geometry(), 0, zero_geometry()});
    recorder.write(made.view());
  }
  const Recording recording = read_recording(file.path());
  ASSERT_EQ(recording.frames.at(0).events.size(), static_cast<std::size_t>(kKinds));
  for (int i = 0; i < kKinds; ++i)
    EXPECT_EQ(recording.frames[0].events[static_cast<std::size_t>(i)].kind, static_cast<EventKind>(i));
}

// A command for a mechanism that is gone.
TEST(RecordReader, KnowsAnEventOfNoObject) {
  const TemporaryFile file("nobody.csv");
  {
    Recorder recorder(file.path());
    MadeFrame made = make_frames(1, 0, 20)[0];
    made.events.push_back({EventKind::refused, {}, {}, {}, 0, zero_geometry(), 0, zero_geometry()});
    recorder.write(made.view());
  }
  EXPECT_EQ(read_recording(file.path()).frames.at(0).events.at(0).b, RecordedEvent::kNone);
}

TEST(RecordReader, NamesFileAndLine) {
  const std::string text = made_record();
  EXPECT_THAT(message_of("frame,1\n"), HasSubstr("line 1: no record"));
  EXPECT_THAT(message_of(""), HasSubstr("no record"));
  std::string bad = text;
  bad.replace(bad.find("frame,0,"), 8, "frame,x,");
  EXPECT_THAT(message_of(bad), HasSubstr("line 2: 'x' is no number"));
  bad = text;
  bad.replace(bad.find("pose,"), 5, "nose,");
  EXPECT_THAT(message_of(bad), HasSubstr("line 3: "));
  bad = text;
  bad.replace(bad.find("frame,3,"), 8, "frame,4,");
  EXPECT_THAT(message_of(bad), HasSubstr("outside of it"));
  bad = text + "end\n";
  EXPECT_THAT(message_of(bad), HasSubstr("fields instead of"));
  EXPECT_THROW(read_recording("/no/such/record.csv"), InputError);
  EXPECT_THROW(read_recording("/tmp"), InputError);
}

TEST(RecordReader, AFrameThatMissesALineInTheMiddleIsRefused) {
  std::string text = made_record();
  const std::size_t line = text.find("pose,2,");
  text.erase(line, text.find('\n', text.find("plain", line) == std::string::npos ? line : line) - line + 1);
  EXPECT_NE(message_of(text), "accepted");
}

}  // namespace
}  // namespace touchstone
