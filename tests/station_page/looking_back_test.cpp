// Saved flights, opened again: wrong ones change nothing.
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

}  // namespace
}  // namespace touchstone::station
