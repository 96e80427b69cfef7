#include "touchstone/adapters/scene_files/script_file.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/program_test.hpp"

namespace touchstone {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kScene = R"(name: Two cubes
frame_rate: 50
contact_gap: 1.0e-9
policy: advance
duration: 2
parameters: {height: 1}
objects:
  - name: table
    hexahedra: [{name: top, box: {size: [1, 1, 1]}}]
  - name: cube
    pose: {position: [0, 0, $height]}
    hexahedra: [{name: cube, box: {size: [1, 1, 1]}}]
    motion:
      segments: [{velocity: [0, 0, -1]}]
)";

class ScriptFile : public FolderTest {
 protected:
  ScriptFile() { write("scene.yaml", kScene); }

  Script load(const std::string& content) const { return load_script(write("script.yaml", content)); }

  /// The script is refused; the message names file and line, and says `reason`.
  void expect_refused(const std::string& content, int line, const std::string& reason) const {
    try {
      load(content);
      ADD_FAILURE() << "not refused: " << reason;
    } catch (const InputError& error) {
      const std::string where = (folder_ / "script.yaml").string() + ":" + std::to_string(line) + ": ";
      EXPECT_THAT(error.what(), ::testing::StartsWith(where));
      EXPECT_THAT(error.what(), HasSubstr(reason));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
};

constexpr const char* kHead = "name: x\nscene: {file: scene.yaml}\n";
const std::string kHands = std::string(kHead) + "hands:\n  - object: cube\n    rates:\n";  // 5 lines

TEST_F(ScriptFile, ReadsWhatItIsGiven) {
  const Script script = load(R"(name: Down
scene: {file: scene.yaml, parameters: {height: 2}}
units: {length: mm, angle: deg}
frame_rate: 100
policy: slide
translation_only: true
duration: 3
hands:
  - object: cube
    rates:
      - {time: 0, velocity: [0, 0, -20]}
      - {time: 1.5, turn: [0, 90, 0], mode: hand}
  - arm: {model: ssrms, link: tip, joints: [1, 2, 3, 4, 5, 6, 90], pose: {position: [1000, 0, 0], rpy: [0, 90, 0]}}
    rates: [{time: 0, velocity: [20, 0, 0]}]
actions:
  - {time: 1, latch: {carrier: cube, carried: table}}
  - {time: 2, release: table}
  - {time: 2, switch_off: table}
)");
  // The script's own settings replace the scene's, in metres and radians.
  EXPECT_EQ(script.scene.frame_rate, 100);
  EXPECT_EQ(script.scene.duration, 3);
  EXPECT_EQ(script.scene.policy, ContactPolicy::slide);
  EXPECT_TRUE(script.translation_only);
  EXPECT_EQ(script.scene.objects[1].X_WO.p.z(), 2.0);
  EXPECT_TRUE(script.scene.objects[1].motion.segments.empty());  // only hands move objects
  // Hands: of an object, and of an arm.
  ASSERT_EQ(script.hands.size(), 2u);
  const HandScript& hand = script.hands[0];
  ASSERT_EQ(hand.rates.size(), 2u);
  EXPECT_EQ(hand.rates[0].velocity, Vector3(0, 0, -0.02));
  EXPECT_EQ(hand.rates[0].mode, HandRates::Mode::world);
  EXPECT_EQ(hand.rates[1].mode, HandRates::Mode::hand);
  EXPECT_NEAR(hand.rates[1].turn.y(), std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(hand.rates[1].velocity, Vector3::Zero());
  EXPECT_FALSE(hand.arm);
  EXPECT_TRUE(script.hands[1].object.empty());
  ASSERT_TRUE(script.hands[1].arm);
  EXPECT_NEAR(script.hands[1].arm->joints[6], std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(script.hands[1].arm->X_WL.p.x(), 1.0);
  EXPECT_NEAR(script.hands[1].arm->X_WL.R(2, 0), -1.0, 1e-15);
  // Actions keep the order and the names that they were given.
  ASSERT_EQ(script.actions.size(), 3u);
  EXPECT_EQ(script.actions[0].carrier, "cube");
  EXPECT_EQ(script.actions[2].kind, OperatorAction::Kind::switch_off);
}

TEST_F(ScriptFile, LeavesObjectsOfTheSceneOut) {
  const Script script = load(
      "name: x\nscene: {file: scene.yaml, without: [table]}\nhands:\n  - object: cube\n    rates: [{time: "
      "0}]\n");
  ASSERT_EQ(script.scene.objects.size(), 1u);
  EXPECT_EQ(script.scene.objects[0].tree.name(), "cube");
}

TEST_F(ScriptFile, RefusesWithFileAndLine) {
  // Settings, scenes and hands.
  expect_refused(std::string(kHead) + "hands: []\nspeed: 3\n", 4, "unknown key 'speed'");
  expect_refused("name: x\nscene: {file: scene.yaml, parameters: {hight: 2}}\nhands: []\n", 2, "'hight'");
  expect_refused("name: x\nscene: {file: nowhere.yaml}\nhands: []\n", 2, "cannot be read");
  expect_refused(std::string(kHead) + "hands: []\n", 3, "at least one hand");
  expect_refused("name: x\nscene: {file: scene.yaml, without: [ball]}\nhands: []\n", 2, "no object 'ball'");
  const std::string arm =
      "  - arm: {model: ssrms, link: tip, joints: [1], pose: {}}\n    rates: [{time: 0}]\n";
  expect_refused(std::string(kHead) + "hands:\n" + arm + arm, 6, "two hands fly 'ssrms'");
  expect_refused(std::string(kHead) + "hands:\n  - rates: [{time: 0}]\n", 4, "expected one of object, arm");
  expect_refused(std::string(kHead) + "frame_rate: 9\nhands: []\n", 3, "not within 10 and 1000 Hz");
  expect_refused(std::string(kHead) + "frame_rate: 1001\nhands: []\n", 3, "not within 10 and 1000 Hz");
  expect_refused(std::string(kHead) + "duration: 0\nhands: []\n", 3, "not above 0");
  expect_refused(std::string(kHead) + "policy: bounce\nhands: []\n", 3, "unknown policy 'bounce'");
  expect_refused(std::string(kHead) + "translation_only: 1\nhands: []\n", 3, "true or false");
  expect_refused(std::string(kHead) + "units: {length: ft}\nhands: []\n", 3, "unknown unit 'ft'");
  expect_refused(std::string(kHead) + "hands:\n  - {object: ball, rates: []}\n", 4, "no object 'ball'");
  expect_refused(std::string(kHead) + "hands:\n  - {object: cube, rates: []}\n", 4, "at least one row");
  // Rows of rates rise in time from the start, in finite numbers and known modes.
  expect_refused(kHands + "      - {time: 0, velocity: [0, 0]}\n", 6, "expected 3 numbers, got 2");
  expect_refused(kHands + "      - {time: 0, velocity: [0, 0, fast]}\n", 6, "expected a number");
  expect_refused(kHands + "      - {time: 0, velocity: [0, 0, .nan]}\n", 6, "not finite");
  expect_refused(kHands + "      - {time: -1}\n", 6, "before the start");
  expect_refused(kHands + "      - {velocity: [0, 0, 1]}\n", 6, "missing 'time'");
  expect_refused(kHands + "      - {time: 1}\n      - {time: 1}\n", 7, "not after the row before");
  expect_refused(kHands + "      - {time: 1, mode: tool}\n", 6, "unknown mode 'tool'");
  expect_refused(kHands + "      - {time: 1}\n  - object: cube\n    rates: [{time: 0}]\n", 7, "two hands");
}

TEST_F(ScriptFile, RefusesActionsThatMeanNothing) {
  const std::string good = kHands + "      - {time: 0}\nactions:\n";  // 7 lines
  expect_refused(good + "  - {time: 1}\n", 8, "expected one of latch");
  expect_refused(good + "  - {time: 1, release: cube, switch_off: cube}\n", 8, "expected one of latch");
  expect_refused(good + "  - {time: 1, release: ball}\n", 8, "no object 'ball'");
  expect_refused(good + "  - {time: 1, latch: {carrier: cube}}\n", 8, "missing 'carried'");
  expect_refused(good + "  - {time: 1, release: cube}\n  - {time: 0, release: cube}\n", 9,
                 "before the action");
}

TEST_F(ScriptFile, RefusesWhatIsNoScript) {
  expect_refused("name: x\nscene: [\n", 3, "malformed YAML");
  expect_refused("name: x\n---\nname: y\n", 2, "one YAML document");
  expect_refused("- a\n- b\n", 1, "expected a map");
  EXPECT_THROW(load_script(folder_ / "nowhere.yaml"), InputError);
  EXPECT_THROW(load_script("/dev/null"), InputError);
}

const std::string kArm =
    "hands:\n  - arm: {model: ssrms, link: tip, joints: [1], pose: {}, hold: true}\n    rates: [{time: 0}]\n"
    "actions:\n";  // 6 lines with the head

TEST_F(ScriptFile, LatchesToLinksOfTheArmsItFlies) {
  // Latched to a link, with an exemption, and released.
  const Script script = load(kHead + kArm +
                             "  - {time: 1, latch: {carrier: ssrms.tip_lee, carried: cube, allowed: "
                             "[[ssrms.wrist_yaw, cube/cube]]}}\n  - {time: 2, release: cube}\n"
                             "  - {time: 3, switch_off: ssrms.upper_boom}\n");
  EXPECT_TRUE(script.hands[0].arm->holds);
  EXPECT_EQ(script.actions[0].carrier, "ssrms.tip_lee");
  EXPECT_EQ(script.actions[0].allowed[0].first, "ssrms.wrist_yaw");
  EXPECT_EQ(script.actions[2].object, "ssrms.upper_boom");
  EXPECT_EQ(script.scene.objects.size(), 2u);  // the links come with the program's arms
  // Links that there are not, and what an arm cannot be carried by.
  const std::string latch = kHead + kArm + "  - {time: 0, latch: ";
  expect_refused(latch + "{carrier: ssrms.hand, carried: cube}}\n", 7, "no object 'ssrms.hand'");
  expect_refused(latch + "{carrier: ssrms.tip, carried: cube}}\n", 7, "no object 'ssrms.tip'");
  expect_refused(latch + "{carrier: table, carried: ssrms.tip_lee}}\n", 7, "carried by nothing");
  expect_refused(latch + "{carrier: ssrms.tip_lee, carried: cube, allowed: [[ssrms.hand, cube]]}}\n", 7,
                 "'ssrms.hand'");
  // An arm is held at a fixture by one of its links.
  const std::string hold = kHead + kArm + "  - {time: 0, hold: ";
  const OperatorAction held = load(hold + "{fixture: table, link: ssrms.base_lee}}\n").actions[0];
  EXPECT_EQ(held.kind, OperatorAction::Kind::hold);
  EXPECT_EQ(held.carrier, "table");
  EXPECT_EQ(held.object, "ssrms.base_lee");
  expect_refused(hold + "{fixture: ssrms.tip_lee, link: ssrms.base_lee}}\n", 7,
                 "fixture: is a link of an arm");
  expect_refused(hold + "{fixture: table, link: cube}}\n", 7, "link: is no link of an arm");
  expect_refused(hold + "{fixture: table}}\n", 7, "link");
  // Links of arms that no hand flies.
  expect_refused(kHands +
                     "      - {time: 0}\nactions:\n  - {time: 0, latch: {carrier: ssrms.tip_lee, carried: "
                     "cube}}\n",
                 8, "no object 'ssrms.tip_lee'");
}

TEST_F(ScriptFile, EveryBundledScriptLoads) {
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(TOUCHSTONE_SCRIPTS)) {
    const Script script = load_script(entry.path());
    EXPECT_FALSE(script.name.empty());
    ++count;
  }
  EXPECT_GE(count, 19u);
}

TEST_F(ScriptFile, ReadsShiftsOfJointsAsLengthsAndTheJointsThatAreHeld) {
  const std::string arm = std::string(kHead) + R"(units: {length: mm, angle: deg}
hands:
  - arm:
      model: ssrms_on_transporter
      link: tip
      joints: [1500, 90, 0, 0, 0, 0, 0, 0]
      held_joints: )";
  const std::string rest = "\n    rates: [{time: 0}]\n";
  const Script script = load(arm + "[rail]\n      pose: {}" + rest);
  const ArmScript& read = *script.hands[0].arm;
  EXPECT_EQ(read.joints[0], 1.5);
  EXPECT_DOUBLE_EQ(read.joints[1], std::numbers::pi / 2);
  EXPECT_EQ(read.held_joints, std::vector<std::string>{"rail"});
  expect_refused(arm + "[wheel]\n      pose: {}" + rest, 9, "wheel");
  expect_refused(arm + "[held]\n      pose: {}" + rest, 9, "joint 'held' does not move");
}

}  // namespace
}  // namespace touchstone
