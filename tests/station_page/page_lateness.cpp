// How late pictures come after the hand, and what was going on where one came late: the real station and its
// page in Chromium on this machine, whose own hand sweeps. No test: a figure of this machine, which shall
// have no other work. station_page_lateness [SECONDS [PAGE]]
#include <cstdio>
#include <string>
#include <vector>

#include "touchstone/tests/station_page/browser.hpp"
#include "touchstone/tests/station_page/running_station.hpp"
#include "touchstone/tests/station_page/temporary_profile.hpp"

namespace {

using touchstone::Browser;
using touchstone::TemporaryProfile;
using touchstone::station::RunningStation;

// By kind, [ms since now, figures]: hand to picture and level; what a picture took; a turn of the page that
// was long; a level left; a picture of all screens; a hand sent (number); a frame that arrives (frame, hand
// that it obeys, ms since it was decided) or is drawn. Of the last second and a half alone; numbers modulo 1
// 000.
constexpr const char* kWatch = R"js((() => {
  // A log of what the page does; late pictures keep the last second and a half of it.
  const {latency, pace, picture, link} = touchstoneStation, log = [], from = performance.now();
  window.late = [];
  const note = (kind, ...of) => {
    log.push([performance.now(), kind, ...of]);
    while (log[0][0] < performance.now() - 1500) log.shift();
  };
  const after = (owner, name, tell) => {
    const was = owner[name].bind(owner);
    owner[name] = (...of) => { tell(...of); return was(...of); };
  };
  // Each part tells the log.
  after(latency, 'add', ms => {
    note('drawn', ms);
    if (ms <= latency.limit) return;
    const now = performance.now();
    window.late.push([(now - from) / 1000, ms, pace.at, log.filter(one => one[0] > now - ms - 50)
      .map(([at, kind, ...of]) => `${kind} ${of.map(value => Number(value).toFixed(0))} at ${(at - now).toFixed(0)}`).join('; ')]);
  });
  after(pace, 'add', took => note('picture', took));
  after(pace, 'lower', by => note('less', by));
  after(pace, 'raise', () => note('more'));
  after(link, 'takeFrame', data => {
    const view = new DataView(data);
    note('arrives', Number(view.getBigUint64(8, true)) % 1000, view.getUint32(68, true) % 1000, (performance.now() * 1000 + link.offset - view.getFloat64(48, true)) / 1000);
  });
  after(link, 'input', () => note('hand', (link.number + 1) % 1000));
  after(picture, 'draw', frame => note('draws', frame.frame % 1000, frame.inputNumber % 1000));
  after(picture, 'choose', (screens, all) => { if (all) note('all screens', screens.length); });
  let last = null;
  after(pace, 'turned', now => { if (last !== null && now - last > 40) note('long turn', now - last); last = now; });
})())js";

void measure(double seconds, const std::vector<std::string>& options) {
  // The station and its page.
  const TemporaryProfile profile("station_page_lateness");
  const RunningStation station("worksite", options);
  Browser browser(profile.path());
  browser.set_window(1440, 900);
  browser.open(station.address() + "?fly&sweep");
  if (!browser.becomes_true("touchstoneStation.station.drawn > 0"))
    throw std::runtime_error("no picture was drawn");
  browser.evaluate(kWatch);
  browser.wait(seconds);
  // Figures that the page kept.
  const nlohmann::json found = browser.evaluate(
      "(async () => { const {latency, pace} = touchstoneStation; "
      "const {deadline, sum_less_input_to_drawn_us: apart} = await (await fetch('/latency.json')).json(); "
      "return {total: latency.total, late: latency.late, worst: latency.worst, "
      "median: latency.percentile(0.5), most: latency.percentile(0.999), "
      "says: pace.says() || 'drawn in full', missed: deadline.missed, steps: deadline.steps, apart, "
      "all: window.late}; })()");
  // Quantiles, deadlines, and each late picture.
  std::printf("hand to picture: median %.0f, 99.9 %% %.0f, worst %.0f ms; later than 150 ms %d of %d\n",
              found["median"].get<double>(), found["most"].get<double>(), found["worst"].get<double>(),
              found["late"].get<int>(), found["total"].get<int>());
  std::printf("deadlines missed %d of %d; %s\n", found["missed"].get<int>(), found["steps"].get<int>(),
              found["says"].get<std::string>().c_str());
  std::printf("sum of the stages against hand to picture: median %.2f, 99.9 %% %.2f, worst %.2f ms\n",
              found["apart"]["median"].get<double>() / 1e3, found["apart"]["p999"].get<double>() / 1e3,
              found["apart"]["worst"].get<double>() / 1e3);
  for (const nlohmann::json& one : found["all"])
    std::printf("at %.1f s, %.0f ms, level %d: %s\n", one[0].get<double>(), one[1].get<double>(),
                one[2].get<int>(), one[3].get<std::string>().c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (Browser::program().empty()) {
    std::puts("no Chromium (Debian: chromium-headless-shell)");
    return 1;
  }
  std::vector<std::string> options;
  if (argc > 2) options = {"--page", argv[2]};
  try {
    measure(argc > 1 ? std::stod(argv[1]) : 60.0, options);
  } catch (const std::exception& error) {
    std::puts(error.what());
    return 1;
  }
  return 0;
}
