// Saved flights, opened again: wrong ones change nothing, right ones leave what is live as the station says
// it.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

TEST_F(StationPage, RefusesAWrongSavedFlightInOneLineAndStaysAsItWas) {
  open();
  ASSERT_TRUE(becomes_true("touchstoneStation.timeline.frames.length > 2"));
  // Of a good flight (texts, frames) each spoils one thing.
  const std::pair<const char*, const char*> wrong[] = {
      {"it.texts = {hello: {}, scene: {}}", "the saved flight names no methods"},
      {"it.texts = null", "the saved flight names no methods"},
      {"it.texts = '{\"hello\"'", "the saved flight's texts are no JSON"},
      {"it.texts.hello.methods[1] = {}", "a method of the saved flight has no name"},
      {"it.texts.scene = {}", "the saved flight has no scene"},
      {"delete it.texts.scene.cameras", "the saved flight's scene has no cameras"},
      {"it.texts.scene.objects[1].solids = [99]", "object 1 of the saved flight's scene is wrong"},
      {"it.texts.scene.objects[2].name = 7", "object 2 of the saved flight's scene is wrong"},
      {"it.texts.scene.solids[2].vertices.pop()", "solid 2 of the saved flight's scene is wrong"},
      {"it.texts.scene.solids[3] = null", "solid 3 of the saved flight's scene is wrong"},
      {"it.texts.scene.arms[0].tip.object = -1", "arm 0 of the saved flight's scene is wrong"},
      {"it.texts.scene.cameras[3].look = 'up'", "camera 3 of the saved flight's scene is wrong"},
      {"it.frames = []", "the saved flight has no frames"},
      {"it.frames[1] = it.frames[1].slice(0, 200)", "frame 1 of the saved flight cannot be read"},
      {"it.texts.scene.objects.pop(); it.texts.scene.solids.pop()",
       "frame 0 of the saved flight is not of its scene"}};
  for (const auto& [spoil, why] : wrong) {
    const int count = value("touchstoneStation.timeline.frames.length");
    value(std::string("document.getElementById('trouble').textContent = ''; (it => { ") + spoil +
          "; seen.openFile(seen.flight(it)); })(seen.shown())");
    EXPECT_TRUE(becomes_true("document.getElementById('trouble').textContent")) << spoil;
    EXPECT_EQ(text("trouble"), std::string("Not opened: ") + why) << spoil;
    EXPECT_EQ(value("(({station: {hello, scene, looking}}) => [hello.methods.length, scene.objects.length, "
                    "Boolean(looking)])(touchstoneStation)"),
              nlohmann::json({4, 4, false}))
        << spoil;
    EXPECT_TRUE(becomes_true("touchstoneStation.timeline.frames.length > " + std::to_string(count)))
        << "frames go on after " << spoil;
    if (HasFailure()) return;
  }
  EXPECT_EQ(text("at"), "live");
}

TEST_F(StationPage, KeepsAnOpenedFlightApartFromWhatIsLive) {
  open();
  ASSERT_TRUE(becomes_true("touchstoneStation.timeline.frames.length > 2"));
  value(R"((it => {
    it.texts.hello = {methods: it.texts.hello.methods.map(({what}, i) => ({name: `saved ${i}`, what})), scenes: [], scene: 'saved'};
    Object.assign(it.texts.scene, {name: 'saved', serial: 77});
    it.texts.scene.objects[2].name = 'saved wall';
    it.texts.scene.arms[0].joints.pop();
    window.saved = seen.flight(it);
  })(seen.shown()))");
  const auto is_live = [&](const std::string& name) {
    return becomes_true("(({station: {scene, hello, looking, frame}}) => !looking && scene.name === '" +
                        name +
                        "' && hello.methods[3].name === 'ours' && frame?.serial === "
                        "fake.serial)(touchstoneStation)");
  };
  const std::string is_opened =
      "(({station: {scene, hello, looking}, timeline}) => looking && scene.name === 'saved' && "
      "hello.methods[3].name === 'saved 3' && timeline.frames.length > 2)(touchstoneStation)";
  const std::string live = "document.getElementById('live').click()";

  value("seen.openFile(window.saved)");
  ASSERT_TRUE(becomes_true(is_opened));
  // The hands' and the instructor's choices are the station's.
  EXPECT_EQ(value("document.getElementById('scenes').options.length"), 2);
  EXPECT_EQ(value("document.getElementById('joint').options.length"), 2);
  value("fake.sockets[0].text({type: 'event', frame: 9, time: 1, kind: 'began', a: 1, b: 2})");
  EXPECT_THAT(text("events"), testing::HasSubstr("arm.tip_lee – wall"));
  value(live);
  EXPECT_TRUE(is_live("made_up"));
  EXPECT_THAT(text("methods"), testing::Not(testing::HasSubstr("saved")));

  // Another scene, live; then a flight again.
  value("fake.choose('second')");
  ASSERT_TRUE(is_live("second"));
  value("seen.openFile(window.saved)");
  ASSERT_TRUE(becomes_true(is_opened));
  value(live);
  EXPECT_TRUE(is_live("second"));

  // Another scene while a flight is open.
  value("seen.openFile(window.saved)");
  ASSERT_TRUE(becomes_true(is_opened));
  value("fake.choose('third')");
  browser_->wait(0.2);
  EXPECT_EQ(value(is_opened), true);
  value(live);
  EXPECT_TRUE(is_live("third"));
  EXPECT_EQ(value("fake.sockets.length"), 1);
}

TEST_F(StationPage, LooksBackOnWhileAnotherSceneIsChosen) {
  open();
  ASSERT_TRUE(becomes_true("touchstoneStation.timeline.frames.length > 5"));
  value(
      "(line => { line.value = '1'; line.dispatchEvent(new Event('input')); "
      "})(document.getElementById('line'))");
  const nlohmann::json at = text("at");
  value("fake.choose('second')");
  browser_->wait(0.2);
  EXPECT_EQ(text("at"), at);
  EXPECT_EQ(value("touchstoneStation.station.scene.name"), "made_up");
  value("document.getElementById('live').click()");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.frame?.serial === 2"));
}

}  // namespace
}  // namespace touchstone::station
