#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/messages/recorded_flight.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Runs of other programs, as the station's page opens them.

namespace touchstone::station {
namespace {

using testing::HasSubstr;

constexpr const char* kScene = R"(name: two
frame_rate: 50
duration: 60
contact_gap: 1.0e-6
policy: cue
objects:
  - {name: a, hexahedra: [{name: s, box: {size: [1, 1, 1]}}, {name: t, pose: {position: [0, 0, 2]}, box: {size: [1, 1, 1]}}]}
  - {name: "b,c", pose: {position: [4, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
)";
constexpr const char* kSeriesHead =
    "time_s,energy_j,a.position_x_m,a.position_y_m,a.position_z_m,a.force_x_n,\"b,c.position_x_m\",\"b,c."
    "position_y_m\",\"b,c.position_z_m\",a.attitude_w,a.attitude_x,a.attitude_y,a.attitude_z,\"b,c."
    "attitude_w\",\"b,c.attitude_x\",\"b,c.attitude_y\",\"b,c.attitude_z\"\n";

template <class Number>
Number at(const std::string& bytes, std::size_t place) {
  Number value{};
  if (place + sizeof(value) <= bytes.size()) std::memcpy(&value, bytes.data() + place, sizeof(value));
  return value;
}

/// A file of the page, in parts.
struct Saved {
  nlohmann::json texts;
  std::vector<std::string> frames;
};

Saved split(const std::string& file) {
  Saved out;
  EXPECT_EQ(file.substr(0, 4), "TSR1");
  std::size_t place = 8 + at<std::uint32_t>(file, 4);
  out.texts = nlohmann::json::parse(file.substr(8, place - 8));
  while (place < file.size()) {
    out.frames.push_back(file.substr(place + 4, at<std::uint32_t>(file, place)));
    place += 4 + out.frames.back().size();
  }
  return out;
}

/// x, y, z, then the quaternion's x, y, z, w, of an object.
std::vector<float> pose_of(const std::string& frame, std::size_t object) {
  std::vector<float> out;
  for (std::size_t i = 0; i < 7; ++i)
    out.push_back(at<float>(frame, kFrameHeader + 64 + 32 * object + 4 * i));
  return out;
}

class StationRecord : public FolderTest {
 protected:
  std::string refusal_of(const std::string& text) {
    const std::filesystem::path record = write("run.csv", text), scene = write("two.yaml", kScene);
    try {
      saved_flight(load_recorded_flight(record, scene));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  Saved open(const std::string& text) {
    const std::filesystem::path record = write("run.csv", text), scene = write("two.yaml", kScene);
    return split(saved_flight(load_recorded_flight(record, scene)));
  }
};

TEST_F(StationRecord, ASeriesBecomesAFlightOfThePage) {
  const Saved saved = open(std::string(kSeriesHead) + "0,9,0,0,0,5,4,0,0,1,0,0,0,1,0,0,0\n" +
                           "0.02,9,0.5,0,-2,5,4,0,0,0.6,0,0.8,0,1,0,0,0\n");
  ASSERT_EQ(saved.frames.size(), 2U);
  const nlohmann::json& scene = saved.texts["scene"];
  EXPECT_EQ(scene["name"], "run");
  EXPECT_EQ(scene["objects"][0]["solids"], nlohmann::json::parse("[0, 1]"));
  EXPECT_EQ(scene["objects"][1]["name"], "b,c");
  EXPECT_EQ(scene["objects"][0]["moves"], true);
  EXPECT_EQ(scene["objects"][1]["moves"], false);
  EXPECT_EQ(scene["solids"].size(), 3U);
  EXPECT_EQ(scene["tips"][0]["object"], 0);
  EXPECT_EQ(saved.texts["hello"]["methods"].size(), 1U);
  const std::string& last = saved.frames[1];
  EXPECT_EQ(at<std::uint32_t>(last, 0), kFrameMagic);
  EXPECT_EQ(at<std::uint64_t>(last, 8), 1U);
  EXPECT_EQ(at<double>(last, 16), 0.02);
  EXPECT_EQ(at<std::uint32_t>(last, 72), 2U);
  EXPECT_EQ(at<std::uint32_t>(last, 108), last.size());
  const std::vector<float> pose = pose_of(last, 0);
  EXPECT_THAT(pose, testing::Pointwise(testing::FloatNear(1e-6F),
                                       std::vector<float>{0.5F, 0.0F, -2.0F, 0.0F, 0.8F, 0.0F, 0.6F}));
  EXPECT_EQ(pose_of(last, 1)[0], 4.0F);
}

TEST_F(StationRecord, ASeriesThatIsNoneIsRefusedByItsLine) {
  const std::string head = kSeriesHead, good = "0,9,0,0,0,5,4,0,0,1,0,0,0,1,0,0,0\n";
  EXPECT_THAT(refusal_of("time_s,energy_j\n0,1\n"), HasSubstr("run.csv:1: no object's position"));
  EXPECT_THAT(refusal_of("time_s,a.position_x_m\n0,1\n"), HasSubstr("run.csv:1: no column 'a.position_y_m'"));
  EXPECT_THAT(refusal_of(head), HasSubstr("run.csv: has no frame"));
  EXPECT_THAT(refusal_of(head + good + "0.02,9,0\n"), HasSubstr("run.csv:3: another number of fields"));
  EXPECT_THAT(refusal_of(head + "0,9,0,nan,0,5,4,0,0,1,0,0,0,1,0,0,0\n"),
              HasSubstr("run.csv:2: 'nan' is no number"));
  EXPECT_THAT(refusal_of(head + "0,9,0,,0,5,4,0,0,1,0,0,0,1,0,0,0\n"),
              HasSubstr("run.csv:2: '' is no number"));
  EXPECT_THAT(refusal_of(head + "0,9,0,0,0,5,4,0,0,0,0,0,0,1,0,0,0\n"), HasSubstr("run.csv:2: no attitude"));
  std::string other = head + good;
  for (std::size_t i = other.find("b,c"); i != std::string::npos; i = other.find("b,c"))
    other.replace(i, 3, "d");
  EXPECT_THAT(refusal_of(other), HasSubstr("two.yaml: has no object 'd'"));
}

#ifdef TOUCHSTONE_HAS_RECORDER

constexpr const char* kRecordHead =
    "record,frame,time,object,other,solid,other_solid,event,part,s,"
    "r00,r01,r02,r10,r11,r12,r20,r21,r22,x,y,z,separation,nx,ny,nz,ax,ay,az,bx,by,bz,"
    "end_separation,end_nx,end_ny,end_nz,end_ax,end_ay,end_az,end_bx,end_by,end_bz,count\n";

std::string commas(std::size_t count) { return std::string(count, ','); }
std::string frame_line(const std::string& time, int rows) {
  return "frame,7," + time + commas(40) + std::to_string(rows) + "\n";
}
std::string pose_line(const std::string& object, const std::string& x) {
  return "pose,7,," + object + commas(7) + "1,0,0,0,1,0,0,0,1," + x + ",0,0" + commas(21) + "\n";
}
std::string contact_line(int solid) {
  const std::string geometry = "0,1,0,0,0.5,0,0,0.5,0,0";
  return "event,7,,a,\"b,c\"," + std::to_string(solid) + ",0,began,0,1" + commas(13) + geometry + "," +
         geometry + ",\n";
}

TEST_F(StationRecord, ARecordBringsItsContacts) {
  const std::string body = pose_line("a", "0.5") + pose_line("\"b,c\"", "1.5");
  const Saved saved = open(kRecordHead + frame_line("0.25", 3) + body + contact_line(1));
  ASSERT_EQ(saved.frames.size(), 1U);
  const std::string& frame = saved.frames[0];
  EXPECT_EQ(at<std::uint64_t>(frame, 8), 7U);
  ASSERT_EQ(at<std::uint32_t>(frame, 80), 1U) << "contacts";
  EXPECT_EQ(pose_of(frame, 1)[0], 1.5F);
  const std::size_t contact = kFrameHeader + 64 + 2 * 2 * 32;
  EXPECT_EQ(at<std::uint32_t>(frame, contact + 4), 1U);
  EXPECT_EQ(at<std::uint32_t>(frame, contact + 8), 2U);  // the only solid of the second object
  EXPECT_EQ(at<float>(frame, contact + 16), 0.5F);
}

TEST_F(StationRecord, ARecordThatThePageCannotShowIsRefused) {
  const std::string head = kRecordHead, body = pose_line("a", "0.5") + pose_line("\"b,c\"", "1.5");
  EXPECT_THAT(refusal_of(""), HasSubstr("no record"));
  EXPECT_THAT(refusal_of(head), HasSubstr("run.csv: has no frame"));
  EXPECT_THAT(refusal_of(head + frame_line("0", 0)), HasSubstr("run.csv: has no frame with an object"));
  EXPECT_THAT(refusal_of(head + frame_line("0", 1) + pose_line("a", "inf")),
              HasSubstr("run.csv: frame 7: the pose of 'a' is not finite"));
  EXPECT_THAT(refusal_of(head + frame_line("nan", 2) + body),
              HasSubstr("run.csv: frame 7: its time is no finite number"));
  EXPECT_THAT(refusal_of(head + frame_line("0", 3) + body + contact_line(2)),
              HasSubstr("run.csv: frame 7: an event names a solid that the scene lacks"));
  EXPECT_THAT(refusal_of(head + frame_line("0", 1) + pose_line("d", "0")),
              HasSubstr("two.yaml: has no object 'd'"));
  EXPECT_THAT(refusal_of(head + "frame,7\n"), HasSubstr("line 2: 2 fields"));
}

#endif

}  // namespace
}  // namespace touchstone::station
