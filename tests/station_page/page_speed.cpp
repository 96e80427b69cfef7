// How fast a browser draws the station's page by software: pictures a second, how old what they show is when
// it is drawn and at most until the next picture, and the processor time that a picture takes, by numbers of
// moving solids. No test: a figure of this machine. station_page_speed [SECONDS]
#include <algorithm>
#include <cstdio>
#include <string>

#include "touchstone/tests/station_page/browser.hpp"
#include "touchstone/tests/station_page/temporary_profile.hpp"

namespace {

constexpr const char* kCounts = "[touchstoneStation.station.drawn, fake.sockets[0].frame, performance.now()]";

/// Turns of the page 200 ms apart. It learns of a picture's end only in its next turn: here ends are asked
/// for every 2 ms, and what was shown the longest, when the next picture took its place, is the oldest.
constexpr const char* kFiveASecond = R"js((() => {
  const {renderer, station, link} = touchstoneStation, {gl} = renderer, turn = requestAnimationFrame;
  window.requestAnimationFrame = of => setTimeout(() => turn(of), 200);
  const mark = renderer.mark.bind(renderer);
  let last = null;
  window.oldest = 0;
  renderer.mark = () => {
    const sync = mark(), {decided} = station.frame;
    const ask = () => {
      if (gl.getSyncParameter(sync, gl.SYNC_STATUS) !== gl.SIGNALED) return setTimeout(ask, 2);
      if (last !== null) window.oldest = Math.max(window.oldest, link.age({decided: last}) / 1000);
      last = decided;
    };
    setTimeout(ask, 2);
    return sync;
  };
})())js";

struct View {
  const char *name, *set;
};
// As the page draws where it is left alone, and held to 5 turns a second; four CCTV screens beside the main
// one; the main one alone; a quarter of its pixels.
constexpr View kViews[] = {
    {"as time allows", "true"},
    {"five a second", kFiveASecond},
    {"five screens", "show('detail', '1')"},
    {"one screen", "show('detail', '1'); document.getElementById('show-cctv').click()"},
    {"one, half detail", "show('detail', '0.5'); document.getElementById('show-cctv').click()"}};

void measure(int solids, const View& view, double seconds) {
  // The page beside a station that is made up.
  const touchstone::TemporaryProfile profile("station_page_speed");
  touchstone::Browser browser(profile.path());
  browser.serve("http://station.test/", PAGE);
  browser.set_window(1440, 900);
  browser.run_before_pages("window.fakeOptions={rate:60,solids:" + std::to_string(solids) + "};" +
                           touchstone::read_file(FAKE_STATION));
  browser.open("http://station.test/?fly");
  browser.becomes_true("touchstoneStation.station.drawn > 0");
  browser.evaluate(
      "window.show = (id, value) => { const node = document.getElementById(id); node.value = value; "
      "node.dispatchEvent(new Event('change')); };" +
      std::string(view.set));
  // Counts and processor time, before and after.
  browser.wait(2.0);
  browser.evaluate("if (window.oldest) window.oldest = 0");
  const nlohmann::json before = browser.evaluate(kCounts);
  const double processor_before = browser.processor_seconds();
  browser.wait(seconds);
  const double processor = browser.processor_seconds() - processor_before;
  const nlohmann::json after = browser.evaluate(kCounts);
  const auto change = [&](int i) { return after[i].get<double>() - before[i].get<double>(); };
  // How old the pictures are.
  const nlohmann::json age = browser.evaluate(
      "touchstoneStation.station.ages.reduce((a, b) => a + b, 0) / touchstoneStation.station.ages.length / "
      "1000");
  const nlohmann::json oldest = browser.evaluate(
      "window.oldest ?? Math.max(...touchstoneStation.station.ages) / 1000 + "
      "Math.max(...touchstoneStation.station.intervals)");
  std::printf("%6d  %-16s  %8.1f  %7.1f  %6.0f  %6.0f  %11.0f\n", solids, view.name,
              change(1) / change(2) * 1e3, change(0) / change(2) * 1e3, age.get<double>(),
              oldest.get<double>(), processor / std::max(1.0, change(0)) * 1e3);
}

}  // namespace

int main(int argc, char** argv) {
  if (touchstone::Browser::program().empty()) {
    std::puts("no Chromium (Debian: chromium-headless-shell)");
    return 1;
  }
  const double seconds = argc > 1 ? std::stod(argv[1]) : 5.0;
  std::puts("solids  view              frames/s  drawn/s  age ms  oldest  processor ms a picture");
  for (const int solids : {1, 500, 5000})
    for (const View& view : kViews) measure(solids, view, seconds);
}
