// How fast a browser draws the station's page by software: pictures a second and the picture's age, by
// numbers of moving solids. No test: a figure of this machine. page_speed [SECONDS]
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "touchstone/tests/station_page/browser.hpp"

namespace {

std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void measure(int solids, const char* detail, double seconds) {
  std::string name = (std::filesystem::temp_directory_path() / "station_page_speed.XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(name.data());
  {
    touchstone::Browser browser(folder / "profile");
    browser.serve("http://station.test/", PAGE);
    browser.set_window(1440, 900);
    browser.run_before_pages("window.fakeOptions={rate:60,solids:" + std::to_string(solids) + "};" +
                             read_file(FAKE_STATION));
    browser.open("http://station.test/?fly");
    browser.becomes_true("touchstoneStation.station.drawn > 2");
    browser.evaluate(
        std::string("(() => { const detail = document.getElementById('detail'); detail.value = '") + detail +
        "'; detail.dispatchEvent(new Event('change')); })()");
    browser.wait(3.0);
    const nlohmann::json before =
        browser.evaluate("[touchstoneStation.station.drawn, fake.sockets[0].frame, performance.now()]");
    browser.wait(seconds);
    const nlohmann::json after =
        browser.evaluate("[touchstoneStation.station.drawn, fake.sockets[0].frame, performance.now()]");
    const double passed = (after[2].get<double>() - before[2].get<double>()) / 1e3;
    const nlohmann::json rest = browser.evaluate(R"((() => {
      const {station, renderer, picture} = touchstoneStation;
      const times = Array.from({length: 50}, () => { const begin = performance.now(); picture.draw(station.frame, station.screens, 'dark'); return performance.now() - begin; }).sort((a, b) => a - b);
      return {age: station.ages.reduce((a, b) => a + b, 0) / station.ages.length / 1000, detail: renderer.detail, submit: times[25]};
    })())");
    std::printf("%6d  %-5s %5.2f  %9.1f  %9.1f  %8.0f  %9.2f\n", solids, detail, rest["detail"].get<double>(),
                (after[1].get<double>() - before[1].get<double>()) / passed,
                (after[0].get<double>() - before[0].get<double>()) / passed, rest["age"].get<double>(),
                rest["submit"].get<double>());
  }
  std::filesystem::remove_all(folder);
}

}  // namespace

int main(int argc, char** argv) {
  if (touchstone::Browser::program().empty()) {
    std::puts("no Chromium (Debian: chromium-headless-shell)");
    return 1;
  }
  const double seconds = argc > 1 ? std::stod(argv[1]) : 5.0;
  std::puts("solids  detail scale  frames/s  drawn/s    age ms  submit ms");
  for (const int solids : {0, 500, 5000})
    for (const char* const detail : {"1", "0.5", "auto"}) measure(solids, detail, seconds);
}
