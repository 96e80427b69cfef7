#include "touchstone/examples/compare_backends/figures/drift_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

// ---- the plot: below the lowest decade stands exactly 0

constexpr double kLeft = 54, kArea = 220, kColumn = 60, kGap = 6;  // of a panel
constexpr double kSide = kLeft + kArea + kGap + kColumn + 12;
constexpr double kRowTop = 28, kRow = 22, kTop = kRowTop + kRow + kGap;
constexpr double kLegend = 170;
constexpr double kLow = -18, kHigh = 2;

struct Panel {
  const char* label;
  double DriftRun::*figure;
};
constexpr Panel kPanels[] = {{"final poses [m]", &DriftRun::pose_error},
                             {"unexplained momentum [N s]", &DriftRun::momentum},
                             {"energy made / scale", &DriftRun::energy_made}};

std::string axes(double left, const LogScale& x, const LogScale& y, const char* label) {
  std::string svg = fmt::format("<text class='title' x='{}' y='18'>{}</text>", left, label);
  const auto area = [&](double from_x, double from_y, double width, double height) {
    svg += fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", from_x, from_y, width,
                       height);
  };
  // Runs without a figure have a column and a row beside the square.
  area(left, kTop, kArea, kArea);
  area(left + kArea + kGap, kTop, kColumn, kArea);
  area(left, kRowTop, kArea, kRow);
  area(left + kArea + kGap, kRowTop, kColumn, kRow);
  // Both axes are logarithmic, and their low ends stand for 0.
  for (int e = static_cast<int>(kLow); e <= static_cast<int>(kHigh); e += 4) {
    const double value = std::pow(10.0, e);
    const std::string text = e == static_cast<int>(kLow) ? "0" : superscript(e);
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}v{2}M{3} {4:.1f}h{2}'/><text x='{0:.1f}' y='{5}' "
        "text-anchor='middle'>{6}</text><text x='{7}' y='{8:.1f}' text-anchor='end'>{6}</text>",
        x(value), kTop, kArea, left, y(value), kTop + kArea + 16, text, left - 5, y(value) + 4);
  }
  // Labels say how to read the column, the row and the x axis.
  return svg +
         fmt::format(
             "<text x='{}' y='{}' text-anchor='end'>stopped</text><text x='{}' y='{}' "
             "text-anchor='middle'>no figure</text><text x='{}' y='{}' text-anchor='middle'>worst error of a "
             "contact / S</text>",
             left - 5, kRowTop + kRow / 2 + 4, left + kArea + kGap + kColumn / 2, kTop + kArea + 16,
             left + kArea / 2, kTop + kArea + 34);
}

// A manifold's worst error by backend; NaN of one that has none.
double contact_error(const std::vector<Ranking>& rankings, const std::string& backend) {
  for (const Ranking& ranking : rankings) {
    if (ranking.query != QueryKind::manifold) continue;
    for (const RankedBackend& each : ranking.standings)
      if (each.backend == backend) return each.worst_error;
  }
  return kNaN;
}

// Where a panel's marks stand along x: by their error, side by side in the column where it is not finite.
class Places {
 public:
  Places(const std::vector<DriftStanding>& standings, const std::vector<Ranking>& rankings, double left)
      : scale_{kLow, kHigh, left + 8, left + kArea - 8} {
    for (const DriftStanding& each : standings) {
      errors_[each.backend] = contact_error(rankings, each.backend);
      if (!std::isfinite(errors_[each.backend])) column_.push_back(each.backend);
    }
    column_from_ = left + kArea + kGap;
  }

  const LogScale& scale() const { return scale_; }
  double error(const std::string& backend) const { return errors_.at(backend); }
  double operator()(const std::string& backend) const {
    if (std::isfinite(error(backend))) return scale_(error(backend));
    const auto at = std::find(column_.begin(), column_.end(), backend) - column_.begin();
    return column_from_ + kColumn * (static_cast<double>(at) + 0.5) / static_cast<double>(column_.size());
  }

 private:
  LogScale scale_;
  std::map<std::string, double> errors_;
  std::vector<std::string> column_;
  double column_from_ = 0;
};

std::string panel_marks(const Drift& drift, const Panel& panel, const Places& at, const LogScale& y,
                        const std::vector<std::string>& backends) {
  std::string svg;
  std::map<std::string, std::string> stopped;  // by backend: the scenes
  for (const DriftRun& run : drift.runs) {
    if (!run.gap.empty()) stopped[run.backend] += "\n" + run.scene + ": " + run.gap;
    const double value = run.*panel.figure;
    if (!run.gap.empty() || !std::isfinite(value)) continue;
    const double mx = at(run.backend), my = y(value);
    svg += fmt::format("<g><title>{}, {}: {}; contact error {} S{}</title>{}</g>", xml_text(run.backend),
                       xml_text(run.scene), format_error(value), format_error(at.error(run.backend)),
                       run.is_within() ? "" : "; not within the limits",
                       mark_at(place_of(backends, run.backend), mx, my, !run.is_within(), 4.0));
    if (std::isfinite(at.error(run.backend)) && at.scale().beyond(at.error(run.backend)) > 0)
      svg += held_mark(mx, my, 1, 0);
    if (y.beyond(value) > 0) svg += held_mark(mx, my, 0, -1);
  }
  for (const auto& [backend, scenes] : stopped) {
    svg += fmt::format("<g><title>{}{}</title>{}</g>", xml_text(backend), xml_text(scenes),
                       mark_at(place_of(backends, backend), at(backend), kRowTop + kRow / 2, true, 4.0));
  }
  return svg;
}

std::string drift_legend(const std::vector<DriftStanding>& standings,
                         const std::vector<std::string>& backends) {
  double y = kTop + 8;
  std::string svg = fmt::format("<text class='small' x='{}' y='{}'>scenes within the limits</text>",
                                3 * kSide + 8, kTop - 12);
  for (const DriftStanding& each : standings) {
    svg += mark_at(place_of(backends, each.backend), 3 * kSide + 14, y, each.within < each.scenes, 5.0) +
           fmt::format("<text class='label' x='{}' y='{:.1f}'>{}: {} of {}</text>", 3 * kSide + 25, y + 4,
                       xml_text(each.backend), each.within, each.scenes);
    y += kLegendStep;
  }
  return svg;
}

}  // namespace

std::vector<std::string> missing_figures(const DriftRun& run) {
  std::vector<std::string> missing;
  for (const Panel& panel : kPanels) {
    if (run.gap.empty() && !std::isfinite(run.*panel.figure)) missing.emplace_back(panel.label);
  }
  return missing;
}

std::string drift_plot(const Drift& drift, const std::vector<Ranking>& rankings,
                       const std::vector<std::string>& backends, bool standalone) {
  const bool has_errors = std::any_of(rankings.begin(), rankings.end(), [](const Ranking& ranking) {
    return ranking.query == QueryKind::manifold && !ranking.standings.empty();
  });
  if (drift.runs.empty() || !has_errors) return "";
  const std::vector<DriftStanding> standings = drift_standings(drift);
  const double height =
      std::max(kTop + kArea + 44, kTop + kLegendStep * static_cast<double>(standings.size() + 1));
  std::string svg = svg_open(3 * kSide + kLegend, height, "dynamics drift against contact error", standalone);
  double left = kLeft;
  for (const Panel& panel : kPanels) {
    const Places at(standings, rankings, left);
    const LogScale y{kLow, kHigh, kTop + kArea - 8, kTop + 8};
    svg += axes(left, at.scale(), y, panel.label) + panel_marks(drift, panel, at, y, backends);
    left += kSide;
  }
  return svg + drift_legend(standings, backends) + "</svg>\n";
}

}  // namespace touchstone::comparison
