#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/station/messages/messages.hpp"
#include "touchstone/examples/station/server/web_files.hpp"
#include "touchstone/tests/station/station_scenes.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Pages' messages and requests, without sockets.

namespace touchstone::station {
namespace {

const StationScenes& scenes() {
  static const StationScenes kScenes = bundled({"grapple", "worksite"});
  return kScenes;
}

TEST(StationMessages, AreReadAsTheProtocolSays) {
  const PageMessage input = read_message(
      R"({"type": "input", "number": 17, "stamp": 1234.5, "translation": [0.5, 0, 0], "rotation": [0, 0, -1], "more": 1})",
      scenes());
  ASSERT_TRUE(std::holds_alternative<InputMessage>(input));
  EXPECT_EQ(std::get<InputMessage>(input).number, 17U);
  EXPECT_EQ(std::get<InputMessage>(input).hand.rotation.z(), -1.0);
  const PageMessage control =
      read_message(R"({"type": "control", "vernier": true, "scene": "worksite", "latch": true})", scenes());
  ASSERT_TRUE(std::holds_alternative<ControlMessage>(control));
  const std::vector<Control>& controls = std::get<ControlMessage>(control).controls;
  ASSERT_EQ(controls.size(), 3U);
  EXPECT_EQ(controls[0].kind, Control::Kind::scene);  // the others are about the new one
  EXPECT_EQ(controls[0].index, 1U);
  EXPECT_EQ(controls[2].index, Control::kAny);
}

TEST(StationMessages, OfJawsAndTipsAreRead) {
  const PageMessage input =
      read_message(R"({"type": "input", "number": 1, "stamp": 0, "grip": -0.5})", scenes());
  ASSERT_TRUE(std::holds_alternative<InputMessage>(input));
  EXPECT_EQ(std::get<InputMessage>(input).hand.grip, -0.5);
  const PageMessage control = read_message(R"({"type": "control", "tip": 1})", scenes());
  ASSERT_TRUE(std::holds_alternative<ControlMessage>(control));
  EXPECT_EQ(std::get<ControlMessage>(control).controls.at(0).kind, Control::Kind::tip);
  EXPECT_EQ(std::get<ControlMessage>(control).controls.at(0).index, 1U);
  for (const char* text : {R"({"type": "control", "tip": -1})", R"({"type": "control", "tip": "tip_2"})",
                           R"({"type": "input", "number": 1, "stamp": 0, "grip": "on"})"})
    EXPECT_TRUE(std::holds_alternative<RefusedMessage>(read_message(text, scenes()))) << text;
}

TEST(StationMessages, ThatAreNoObjectsAreGarbage) {
  const std::string deep(60'000, '[');
  for (const std::string& text : {std::string("no"), std::string(""), std::string("[]"), std::string("3"),
                                  std::string("{"), std::string("\xff\xfe"), deep})
    EXPECT_TRUE(std::holds_alternative<GarbageMessage>(read_message(text, scenes()))) << text.substr(0, 20);
}

TEST(StationMessages, ThatSayWhatCannotBeAreRefusedWithAReason) {
  for (const char* text :
       {R"({})",
        R"({"type": 3})",
        R"({"type": "fly"})",
        R"({"type": "input", "number": -1, "stamp": 0})",
        R"({"type": "input", "number": 1.5, "stamp": 0})",
        R"({"type": "input", "number": 1})",
        R"({"type": "input", "number": 1, "stamp": 0, "translation": [1, 2]})",
        R"({"type": "input", "number": 1, "stamp": 0, "rotation": [1, 2, "x"]})",
        R"({"type": "input", "number": 1, "stamp": 0, "translation": [1e999, 0, 0]})",
        R"({"type": "control"})",
        R"({"type": "control", "scene": "nowhere"})",
        R"({"type": "control", "vernier": 1})",
        R"({"type": "control", "frame_of_command": "camera", "camera": [0, 0, 0, 0]})",
        R"({"type": "control", "mode": "joint", "joint": -3})",
        R"({"type": "control", "select": 3})",
        R"({"type": "control", "methods": [9]})",
        R"({"type": "control", "methods": {}})",
        R"({"type": "control", "policy": "shove"})",
        R"({"type": "control", "latch": false})",
        R"({"type": "control", "fault": {"kind": "joint brake", "joint": 99, "on": true}})",
        R"({"type": "drawn", "frame": 1e300, "stamp": 0})"}) {
    const PageMessage message = read_message(text, scenes());
    // A number that no double holds is no JSON for the reader.
    const bool is_refused =
        std::holds_alternative<RefusedMessage>(message) || std::holds_alternative<GarbageMessage>(message);
    EXPECT_TRUE(is_refused) << text;
  }
}

TEST(StationMessages, OfForcesAreRead) {
  const auto only = [](const std::string& text) {
    const PageMessage message = read_message(text, scenes());
    const auto* control = std::get_if<ControlMessage>(&message);
    return control != nullptr && control->controls.size() == 1 ? control->controls[0] : Control{};
  };
  EXPECT_EQ(only(R"({"type": "control", "policy": "push"})").index, kPush);
  const Control dynamics = only(R"({"type": "control", "dynamics": true})");
  EXPECT_EQ(dynamics.kind, Control::Kind::dynamics);
  EXPECT_TRUE(dynamics.on);
  const Control loss =
      only(R"({"type": "control", "fault": {"kind": "torque loss", "joint": 3, "share": 0.25}})");
  EXPECT_EQ(loss.kind, Control::Kind::torque_loss);
  EXPECT_EQ(loss.index, 3U);
  EXPECT_EQ(loss.value, 0.25);
}

TEST(StationFigures, AnInfiniteTimeIsALongOne) {
  TimeHistogram times;
  times.add(kInfinity);
  times.add(1e300);
  EXPECT_EQ(times.count(), 2U);
  EXPECT_EQ(times.above(1e6), 2U);
}

TEST(StationMessages, OfTheSceneHaveEverySolidOnceInItsObjectsFrame) {
  const nlohmann::json scene = nlohmann::json::parse(scene_json(*scenes()[1], 7));
  EXPECT_EQ(scene["serial"], 7);
  EXPECT_EQ(scene["solids"].size(), scenes()[1]->setting.instance().solids().size());
  std::size_t listed = 0;
  for (const auto& object : scene["objects"]) listed += object["solids"].size();
  EXPECT_EQ(listed, scene["solids"].size());
  for (const auto& solid : scene["solids"]) EXPECT_EQ(solid["vertices"].size(), 24U);
  // The end effector's mouth is in the plane of the flown frame.
  EXPECT_EQ(scene["objects"][scene["arms"][0]["hand"].get<std::size_t>()]["name"], "ssrms.tip_lee");
}

TEST(StationMessages, OfTheDebriefHaveGoalsPathAndEvents) {
  StateMessage state;
  state.scene = 1;
  state.figures.done_at[0] = 3.5;
  state.figures.time = 9.0;
  state.figures.path = 2.0;
  const std::vector<std::array<double, 4>> path = {{0.0, 1.0, 2.0, 3.0}, {0.2, 1.0, 2.0, 2.9}};
  StationEvent event;
  event.kind = StationEvent::Kind::latched;
  const nlohmann::json debrief =
      nlohmann::json::parse(debrief_json(state, scenes(), path, {event_json(event)}));
  EXPECT_EQ(debrief["tasks"][0]["done"], true);
  EXPECT_EQ(debrief["tasks"][0]["elapsed"], 3.5);
  EXPECT_EQ(debrief["tasks"][1]["done"], false);
  EXPECT_EQ(debrief["path"][1][3], 2.9);
  EXPECT_EQ(debrief["events"][0]["kind"], "latched");
  EXPECT_EQ(nlohmann::json::parse(score_json(state, scenes()))["path"], 2.0);
}

TEST(StationFigures, QuantilesAreWithinABucketOfTheTruth) {
  TimeHistogram times;
  for (int i = 1; i <= 10000; ++i) times.add(i);
  EXPECT_NEAR(times.quantile_us(0.5), 5000.0, 0.07 * 5000.0);
  EXPECT_NEAR(times.quantile_us(0.999), 9990.0, 0.07 * 9990.0);
  EXPECT_EQ(times.worst_us(), 10000.0);
  EXPECT_EQ(times.quantile_us(1.0), 10000.0);
  EXPECT_NEAR(static_cast<double>(times.above(8000.0)), 2000.0, 600.0);
  times.add(1e12);
  times.add(-5.0);
  times.add(0.0);
  EXPECT_EQ(times.count(), 10003U);
}

class StationFiles : public FolderTest {};

TEST_F(StationFiles, AreServedFromBelowTheirFolderAlone) {
  std::filesystem::create_directories(folder_ / "page/parts");
  const std::filesystem::path folder = write("page/index.html", "page").parent_path();
  write("page/parts/a.js", "a");
  write("secret.txt", "secret");
  std::filesystem::create_symlink(folder.parent_path() / "secret.txt", folder / "link.txt");
  EXPECT_TRUE(file_below(folder, "/index.html"));
  EXPECT_TRUE(file_below(folder, "/parts/a.js"));
  for (const char* path : {"/../secret.txt", "/parts/../../secret.txt", "/link.txt", "/parts", "/", "",
                           "index.html", "//index.html", "/.hidden", "/%2e%2e/secret.txt", "/nothing"})
    EXPECT_FALSE(file_below(folder, path)) << path;
}

TEST(StationHosts, AreThisMachineOnlyByItsOwnNames) {
  EXPECT_TRUE(is_loopback_host("127.0.0.1:8090", 8090));
  EXPECT_TRUE(is_loopback_host("localhost:8090", 8090));
  for (const char* host :
       {"127.0.0.1:8091", "127.0.0.1", "evil.example:8090", "127.0.0.1:8090.evil.example", ""})
    EXPECT_FALSE(is_loopback_host(host, 8090)) << host;
}

TEST(StationTokens, AreFoundInTargetsAndCookies) {
  EXPECT_EQ(split_target("/socket?a=b&token=secret&c").token, "secret");
  EXPECT_EQ(split_target("/socket?token=secret").path, "/socket");
  EXPECT_EQ(split_target("/").token, "");
  EXPECT_EQ(token_in_cookies("a=b; station_token=secret; c=d"), "secret");
  EXPECT_EQ(token_in_cookies("my_station_token=secret"), "");
  EXPECT_TRUE(is_same_secret("abc", "abc"));
  EXPECT_FALSE(is_same_secret("abc", "abd"));
  EXPECT_FALSE(is_same_secret("abc", "ab"));
}

}  // namespace
}  // namespace touchstone::station
