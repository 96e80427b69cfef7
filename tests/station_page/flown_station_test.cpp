// The real station in a real browser: the loop from key to picture, and what the four methods show on the
// way.

#include <cstdlib>

#include "touchstone/tests/station_page/running_station.hpp"
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

class FlownStation : public StationPage {
 protected:
  void SetUp() override {
    StationPage::SetUp();
    if (browser_) browser_->call("Fetch.disable");  // the station serves
  }
};

TEST_F(FlownStation, StopsAtContactWhereOthersMergeAndAgreesOnTheTimes) {
  const RunningStation station("worksite");
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.drawn > 0"));
  const nlohmann::json before = value("touchstoneStation.station.frame.joints.map(joint => joint.actual)");

  // By key: the arm's joints move.
  browser_->press("KeyW");
  ASSERT_TRUE(
      becomes_true("touchstoneStation.station.frame.joints.some((joint, i) => Math.abs(joint.actual - " +
                   before.dump() + "[i]) > 0.001)"));
  browser_->press("KeyW", false);
  // On to what is nearest: ours stops, and no check does not.
  browser_->press("KeyY");
  browser_->press("KeyY", false);
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[3].contact"));
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[0].worst > 0.02"));
  EXPECT_TRUE(becomes_true("['contact', 'blocked'].includes(document.documentElement.dataset.tone)"));
  EXPECT_GT(value("touchstoneStation.renderer.markCount").get<int>(), 0);
  EXPECT_EQ(value("touchstoneStation.station.frame.methods[3].merged"), 0);
  EXPECT_GT(value("touchstoneStation.station.frame.methods[3].judged").get<int>(), 20);
  EXPECT_EQ(value("touchstoneStation.station.frame.methods[3].worst"), 0.0);

  // The station adds up its stages over its own clock; the page subtracts two readings of the browser's.
  value("touchstoneStation.hand.letGo()");
  ASSERT_TRUE(becomes_true("!touchstoneStation.station.assisting"));
  const nlohmann::json apart = value(
      "(async () => { await new Promise(done => setTimeout(done, 1000)); const said = await "
      "(await fetch('/latency.json')).json(), {latency} = touchstoneStation; return [latency.total, "
      "latency.worst, said.count, said.stages_us.input_to_drawn.worst / 1000]; })()");
  EXPECT_GT(apart[0].get<int>(), 0);
  EXPECT_EQ(apart[0], apart[2]);
  EXPECT_NEAR(apart[1].get<double>(), apart[3].get<double>(), 1.0) << "ms";
  // It opens again the file that it saves of the real station.
  EXPECT_EQ(
      value("(async () => { const {timeline, station: {hello, scene}} = touchstoneStation, bytes = await "
            "timeline.file(hello, scene).arrayBuffer(), again = new timeline.constructor(); return "
            "again.open(bytes).scene.name; })()"),
      "worksite");
  for (const std::string& asked : browser_->requests())
    EXPECT_TRUE(asked.rfind(station.address(), 0) == 0 || asked.rfind("data:", 0) == 0 ||
                asked.rfind("ws" + station.address().substr(4), 0) == 0)
        << asked;
}

TEST_F(FlownStation, ShowsForcesAndTorquesAndWhatAnInstructorBreaks) {
  const RunningStation station("worksite", {"--dynamics"});
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.drawn > 0"));
  ASSERT_TRUE(becomes_true("touchstoneStation.station.state.dynamics"));
  EXPECT_EQ(value("document.getElementById('forces').hidden"), false);
  EXPECT_EQ(value("document.getElementById('policy').value"), "push");

  // On to what is nearest, and pressed against it: the read-outs are those of the frames.
  browser_->press("KeyY");
  browser_->press("KeyY", false);
  ASSERT_TRUE(becomes_true("parseFloat(document.getElementById('force').textContent) > 20"));
  EXPECT_TRUE(becomes_true("parseFloat(document.getElementById('torque').textContent) > 1"));
  EXPECT_GT(value("touchstoneStation.station.frame.joints.filter(joint => joint.torque).length").get<int>(),
            3);
  EXPECT_EQ(value("touchstoneStation.station.frame.methods[3].worst"), 0.0);
  ASSERT_TRUE(becomes_true("document.getElementById('score').textContent.includes('largest force')"));
  //  An instructor takes a joint's torque, and is shown what is broken.
  value(
      "(() => { const fault = document.getElementById('fault-torque'); fault.value = '0.1'; "
      "fault.dispatchEvent(new Event('change')); })()");
  EXPECT_TRUE(becomes_true("document.getElementById('faults').textContent.includes('torque loss')"));
  // Without forces again: none is shown.
  value("document.getElementById('dynamics').click()");
  EXPECT_TRUE(
      becomes_true("document.getElementById('forces').hidden && !touchstoneStation.station.state.dynamics"));
}

TEST_F(FlownStation, AnArmWalksByThePagesKeys) {
  const RunningStation station("walk_off");
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.drawn > 0"));
  ASSERT_TRUE(becomes_true("document.getElementById('held').textContent === 'base_tip is held by pdgf_a'"));
  const auto press = [&](const char* key) {
    browser_->press(key);
    browser_->press(key, false);
  };
  // The end that it stands on is not flown.
  press("KeyN");
  EXPECT_TRUE(
      becomes_true("document.getElementById('events').textContent.includes('the arm stands on base_tip')"));
  ASSERT_EQ(value(kFlyTo), true);
  value("window.flyTo([0, 0, 0.05])");
  ASSERT_TRUE(becomes_true("window.away < 0.01"));
  value("window.flyTo(null)");
  press("KeyG");
  ASSERT_TRUE(becomes_true("document.getElementById('held').textContent.startsWith('Both ends are held')"));
  press("KeyN");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.state.tip === 1"));
  press("KeyH");
  ASSERT_TRUE(becomes_true("document.getElementById('held').textContent === 'tip is held by pdgf_b'"));
  // Backwards is up, for an end that looks down: the one that was the base moves, the other one stands.
  const char* const heights =
      "['base_lee', 'tip_lee'].map(link => touchstoneStation.station.frame.methods.at(-1).poses[8 * "
      "touchstoneStation.station.scene.objects.findIndex(object => object.name === 'ssrms.' + link) + 2])";
  // Texts may be seconds ahead of the poses that a busy machine has drawn.
  const auto seen = value("touchstoneStation.station.frame.time").get<double>();
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.time > " + std::to_string(seen + 4.0)));
  const nlohmann::json before = value(heights);
  browser_->press("KeyS");
  EXPECT_TRUE(becomes_true(std::string(heights) + "[0] > " + before[0].dump() + " + 0.2"));
  browser_->press("KeyS", false);
  EXPECT_EQ(value(heights)[1], before[1]);
  EXPECT_EQ(value("touchstoneStation.station.frame.methods[3].merged"), 0);
}

TEST_F(FlownStation, APageThatIsClosedLetsGoAndOpenedAgainFliesOn) {
  const RunningStation station("grapple");
  ASSERT_NE(station.address(), "");
  const std::string joints = "touchstoneStation.station.frame.joints.map(joint => joint.actual)";
  browser_->open(station.address() + "?fly");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.drawn > 0"));
  const nlohmann::json before = value(joints);
  browser_->press("KeyS");
  ASSERT_TRUE(becomes_true("String(" + joints + ") !== '" +
                           value("String(" + joints + ")").get<std::string>() + "'"));
  // Closed with the key held down.
  browser_->open("about:blank");
  browser_->wait(1.0);
  browser_->press("KeyS", false);
  browser_->open(station.address());
  ASSERT_TRUE(becomes_true("window.touchstoneStation && touchstoneStation.station.drawn > 0"));
  EXPECT_EQ(value("document.getElementById('help').open"), false) << "known from before";
  const nlohmann::json stands = value(joints);
  EXPECT_NE(stands, before) << "where it was left, not at the start";
  const int frame = value("touchstoneStation.station.frame.frame");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.frame > " + std::to_string(frame + 20)));
  EXPECT_EQ(value(joints), stands) << "nobody holds a hand";
  browser_->press("KeyS");
  EXPECT_TRUE(becomes_true("String(" + joints + ") !== '" +
                           value("String(" + joints + ")").get<std::string>() + "'"));
  EXPECT_TRUE(becomes_true("document.getElementById('pilot').textContent === 'you fly'"));
  browser_->press("KeyS", false);
}

TEST_F(FlownStation, ASweepingHandIsTimedFromHandToPicture) {
  const RunningStation station("grapple");
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly&sweep");
  ASSERT_TRUE(becomes_true("touchstoneStation.latency.total > 10"));
  EXPECT_GT(value("(async () => (await (await fetch('/latency.json')).json()).count)()").get<int>(), 5);
}

TEST_F(FlownStation, OpensARecordOnTheTimeLineAndGoesBackToTheLiveArm) {
  const std::string flight = (folder_ / "flight.jsonl").string(), poses = (folder_ / "poses").string();
  const std::string station_program = STATION;
  const auto runs = [](const std::string& command) {
    return std::system((command + " > /dev/null").c_str()) == 0;
  };
  ASSERT_TRUE(runs(station_program + " --port 0 --seconds 0.6 --scene grapple --record " + flight));
  ASSERT_TRUE(runs(station_program + " --replay " + flight + " --poses " + poses));
  const RunningStation station("worksite", {"--open", poses + "/flight.csv", "--of", SCENES "/grapple.yaml"});
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly");
  ASSERT_TRUE(
      becomes_true("touchstoneStation.station.looking && touchstoneStation.station.scene.name === 'flight'"));
  EXPECT_EQ(value("touchstoneStation.timeline.frames.length"), 31);
  EXPECT_THAT(text("at"), testing::HasSubstr("frame 0"));
  EXPECT_TRUE(becomes_true("touchstoneStation.station.drawn > 0"));
  browser_->press("KeyP");
  browser_->press("KeyP", false);
  EXPECT_TRUE(becomes_true("Number(document.getElementById('line').value) > 5"));
  value("document.getElementById('live').click()");
  EXPECT_TRUE(becomes_true(
      "touchstoneStation.station.scene.name === 'worksite' && !touchstoneStation.station.looking"));
}

#ifdef TOUCHSTONE_ROBOTS
TEST_F(FlownStation, ShowsARobotsMeshesAndItsHexahedraOnAKey) {
  const RunningStation station(TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf", {"--over", "box"});
  ASSERT_NE(station.address(), "");
  browser_->open(station.address() + "?fly");
  const std::string renderer = "touchstoneStation.renderer";
  ASSERT_TRUE(becomes_true("touchstoneStation.station.drawn > 0 && " + renderer + ".meshes.length === 3"));
  EXPECT_EQ(value(renderer + ".meshes.reduce((sum, mesh) => sum + mesh.corners.length / 9, 0)"), 128);
  EXPECT_EQ(value("document.getElementById('meshes').hidden"), false);
  // A saved flight has no meshes in it.
  EXPECT_EQ(value("JSON.stringify(touchstoneStation.live.scene).includes('corners')"), false);
  // However slowly it is drawn here.
  value(
      "document.getElementById('detail').value = '1'; document.getElementById('detail').dispatchEvent(new "
      "Event('change'))");
  ASSERT_TRUE(becomes_true(renderer + ".meshRuns.length > 0"));
  browser_->press("KeyB");
  browser_->press("KeyB", false);
  EXPECT_TRUE(becomes_true(renderer + ".meshRuns.length === 0"));
  browser_->press("KeyB");
  browser_->press("KeyB", false);
  EXPECT_TRUE(becomes_true(renderer + ".meshRuns.length > 0"));
  // Another scene has none, and says nothing of them.
  value("touchstoneStation.link.control({scene: 'grapple'})");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.scene.name === 'grapple' && " + renderer +
                           ".meshes.length === 0 && document.getElementById('meshes').hidden"));
}
#endif

}  // namespace
}  // namespace touchstone::station
