#include "touchstone/examples/compare_backends/dynamics_drift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/plot_scale.hpp"
#include "touchstone/examples/compare_backends/results_file.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"
#include "touchstone/examples/program/json_error.hpp"
#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

// NaN: not measured. @throws InputError for what is below what such a figure can be.
double checked(const Json& run, const char* key, const DriftRun& of) {
  const double value = number_of(run.at(key));
  if (value < 0)
    throw InputError(
        fmt::format("--dynamics: scene {}, backend {}: {} is negative", of.scene, of.backend, key));
  return value;
}

DriftRun run_of(const Json& scene, const Json& run) {
  DriftRun drift;
  drift.scene = scene.at("scene");
  drift.backend = run.at("backend");
  drift.build_on = scene.at("build_on") == drift.backend;
  if (run.contains("not_run")) {
    drift.gap = run.at("not_run");
    return drift;
  }
  if (!run.at("stopped").is_null()) drift.gap = "stopped: " + run.at("stopped").get<std::string>();
  drift.pose_error = checked(run, "pose_error_m", drift);
  drift.momentum = checked(run, "unexplained_momentum_ns", drift);
  // Where nothing has energy there is no share of it: 0 over 0 is no figure, and neither is more over 0.
  const double made = checked(run, "energy_made_j", drift), scale = checked(run, "energy_scale_j", drift);
  drift.energy_made = scale > 0 ? made / scale : std::numeric_limits<double>::quiet_NaN();
  drift.deepest = checked(run, "deepest_m", drift);
  drift.step_ns = 1e3 * checked(run.at("step_us"), "median", drift);
  for (const Json& answer : run.at("answers")) {
    ++drift.answers;
    drift.met += answer.at("holds").get<bool>() ? 1 : 0;
  }
  return drift;
}

// ---- the plot: below the lowest decade stands exactly 0

constexpr double kSide = 322, kLeft = 54, kArea = 250, kTop = 30;
constexpr double kLow = -18, kHigh = 2;

struct Panel {
  const char* label;
  double DriftRun::*figure;
};
constexpr Panel kPanels[] = {{"final poses [m]", &DriftRun::pose_error},
                             {"unexplained momentum [N s]", &DriftRun::momentum},
                             {"energy made / scale", &DriftRun::energy_made}};

std::string axes(double left, const LogScale& x, const LogScale& y, const char* label) {
  std::string svg =
      fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", left, kTop, kArea, kArea);
  for (int e = static_cast<int>(kLow); e <= static_cast<int>(kHigh); e += 4) {
    const double value = std::pow(10.0, e);
    const std::string text = e == static_cast<int>(kLow) ? "0" : superscript(e);
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}v{2}M{3} {4:.1f}h{2}'/><text x='{0:.1f}' y='{5}' "
        "text-anchor='middle'>{6}</text><text x='{7}' y='{8:.1f}' text-anchor='end'>{6}</text>",
        x(value), kTop, kArea, left, y(value), kTop + kArea + 16, text, left - 5, y(value) + 4);
  }
  return svg + fmt::format("<text class='title' x='{}' y='18'>{}</text>", left, label) +
         fmt::format("<text x='{}' y='{}' text-anchor='middle'>worst error of a contact / S</text>",
                     left + kArea / 2, kTop + kArea + 34);
}

// Those with a finite worst error of a manifold.
std::vector<Standing> contact_errors(const std::vector<Ranking>& rankings) {
  std::vector<Standing> standings;
  for (const Ranking& ranking : rankings) {
    if (ranking.query != QueryKind::manifold) continue;
    std::copy_if(ranking.standings.begin(), ranking.standings.end(), std::back_inserter(standings),
                 [](const Standing& each) { return std::isfinite(each.worst_error); });
  }
  return standings;
}

}  // namespace

std::vector<DriftRun> load_drift(const std::string& path) {
  const std::string who = "--dynamics";
  try {
    const Json results = Json::parse(read_file(path, who));
    if (results.at("program") != "dynamics_run")
      throw InputError(who + ": " + path + " is none of dynamics_run");
    std::vector<DriftRun> runs;
    for (const Json& scene : results.at("scenes"))
      for (const Json& run : scene.at("runs")) runs.push_back(run_of(scene, run));
    return runs;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(who + ": " + path + ": " + reason_of(error));
  }
}

std::vector<std::string> missing_figures(const DriftRun& run) {
  std::vector<std::string> missing;
  for (const Panel& panel : kPanels) {
    if (run.gap.empty() && !std::isfinite(run.*panel.figure)) missing.emplace_back(panel.label);
  }
  return missing;
}

std::string drift_plot(const std::vector<DriftRun>& runs, const std::vector<Ranking>& rankings,
                       const std::vector<std::string>& backends, bool standalone) {
  const std::vector<Standing> standings = contact_errors(rankings);
  if (runs.empty() || standings.empty()) return "";
  std::string svg =
      svg_open(3 * kSide, kTop + kArea + 44, "dynamics drift against contact error", standalone);
  double left = kLeft;
  for (const Panel& panel : kPanels) {
    const LogScale x{kLow, kHigh, left + 8, left + kArea - 8}, y{kLow, kHigh, kTop + kArea - 8, kTop + 8};
    svg += axes(left, x, y, panel.label);
    for (const Standing& standing : standings) {
      for (const DriftRun& run : runs) {
        const double value = run.*panel.figure;
        if (run.backend != standing.backend || !run.gap.empty() || !std::isfinite(value)) continue;
        svg += fmt::format(
            "<g><title>{}, {}: {}; contact error {} S</title>{}</g>", xml_text(standing.backend),
            xml_text(run.scene), format_error(value), format_error(standing.worst_error),
            mark_at(place_of(backends, standing.backend), x(standing.worst_error), y(value), false, 4.0));
        if (x.beyond(standing.worst_error) > 0) svg += held_mark(x(standing.worst_error), y(value), 1, 0);
        if (y.beyond(value) > 0) svg += held_mark(x(standing.worst_error), y(value), 0, -1);
      }
    }
    left += kSide;
  }
  return svg + "</svg>\n";
}

}  // namespace touchstone::comparison
