// Saves the pictures that the station's README shows: the real station, flown in Chromium by its page's keys.
// station_page_pictures FOLDER
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/tests/station_page/browser.hpp"
#include "touchstone/tests/station_page/running_station.hpp"
#include "touchstone/tests/station_page/temporary_profile.hpp"

namespace {

using touchstone::Browser;
using touchstone::station::RunningStation;

struct Picture {
  const char *name, *scene;
  std::vector<std::string> options, keys;
  const char* flight;  ///< what starts beside the keys
  const char* until;   ///< of the shown frame `f`
  bool brakes;         ///< then: what no check stops would sink on
  const char* scheme = "light";
  int width = 1440, height = 900;
};

const std::vector<Picture> kPictures = {
    {"page_dark",
     "worksite",
     {},
     {"KeyC", "KeyY"},
     "true",
     "f.methods[0].depth > 0.05 && f.methods[1].depth > 0.01",
     true,
     "dark"},
    {"page_light", "worksite", {}, {"KeyY"}, "true", "f.methods[3].blocked", false},
    {"page_phone", "worksite", {}, {"KeyY"}, "true", "f.methods[3].blocked", false, "light", 390, 844},
    {"page_walk_off", "walk_off", {}, {}, "flyTo([0, 0, 0.3])", "window.away < 0.02", false},
#ifdef TOUCHSTONE_ROBOTS
    {"page_robot",
     TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf",
     {"--over", "5%"},
     {"KeyY"},
     "true",
     "f.methods[3].contact",
     false},
#endif
};

/// @throws std::runtime_error: a page that does not come so far.
void wait_until(Browser& browser, const Picture& picture, const std::string& expression) {
  if (!browser.becomes_true(expression, 180.0))
    throw std::runtime_error(std::string(picture.name) + ": never " + expression);
}

void take(const Picture& picture, const std::filesystem::path& folder) {
  const touchstone::TemporaryProfile profile("station_page_pictures");
  const RunningStation station(picture.scene, picture.options);
  Browser browser(profile.path());
  browser.set_window(picture.width, picture.height, picture.width < 500);
  browser.set_media({{{"name", "prefers-color-scheme"}, {"value", picture.scheme}}});
  browser.open(station.address() + "?fly");
  wait_until(browser, picture, "touchstoneStation.station.drawn > 0");
  browser.evaluate(touchstone::station::kFlyTo);
  browser.evaluate(picture.flight);
  for (const std::string& key : picture.keys) browser.press(key), browser.press(key, false);
  wait_until(browser, picture, "(f => " + std::string(picture.until) + ")(touchstoneStation.station.frame)");
  if (picture.brakes) browser.press("Space"), browser.press("Space", false);
  // Two pixels each way for one of the picture, and all detail: smooth, whoever draws.
  browser.set_window(picture.width, picture.height, picture.width < 500, 2.0);
  browser.evaluate(
      "(node => { node.value = '1'; node.dispatchEvent(new Event('change')); })(document.getElementById("
      "'detail'))");
  browser.wait(5.0);
  browser.save_picture(folder / (std::string(picture.name) + ".png"), 0.5);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || Browser::program().empty()) {
    std::puts(argc != 2 ? "station_page_pictures FOLDER" : "no Chromium (Debian: chromium-headless-shell)");
    return 2;
  }
  try {
    for (const Picture& picture : kPictures) {
      take(picture, argv[1]);
      std::printf("%s.png\n", picture.name);
    }
  } catch (const std::exception& error) {
    std::puts(error.what());
    return 1;
  }
  return 0;
}
