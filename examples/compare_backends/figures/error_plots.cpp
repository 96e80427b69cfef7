#include "touchstone/examples/compare_backends/figures/error_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

// ---- distributions

constexpr double kWidth = 616, kHeight = 270, kLeft = 46, kTop = 30, kBottom = 226;
constexpr double kZero = 62;  // where exactly 0 stands
constexpr double kAxisLeft = 84, kAxisRight = 466;

double height_of(double share) { return kBottom + (kTop + 8 - kBottom) * share; }

std::string distribution_axes(const LogScale& x) {
  std::string svg = fmt::format(
      "<rect class='area' x='{}' y='{}' width='{}' height='{}'/><rect class='area' x='{}' y='{}' "
      "width='28' height='{}'/>",
      kAxisLeft, kTop, kAxisRight - kAxisLeft, kBottom - kTop, kLeft, kTop, kBottom - kTop);
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    svg += fmt::format(
        "<path class='grid' d='M{0} {3:.1f}h28M{1} {3:.1f}H{2}'/><text x='{4}' y='{5:.1f}' "
        "text-anchor='end'>{6:.0f} %</text>",
        kLeft, kAxisLeft, kAxisRight, height_of(share), kLeft - 5, height_of(share) + 3.5, 100 * share);
  }
  const int low = static_cast<int>(x.low), high = static_cast<int>(x.high);
  const int step = std::max(1, (high - low + 6) / 7);
  for (int e = high; e >= low; e -= step) {
    const double at = x(std::pow(10.0, e));
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4}</text>",
        at, kTop, kBottom, kBottom + 17, superscript(e));
  }
  return svg + fmt::format(
                   "<text x='{}' y='{}' text-anchor='middle'>0</text><path class='break' d='M{} {}l4 "
                   "-9m2 9l4 -9'/>",
                   kZero - 2, kBottom + 17, kAxisLeft - 10, kBottom + 4.5);
}

std::string distribution_line(const Curve& values, const LogScale& x, int place) {
  std::string path, marks;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) break;
    const double at = values[i] > 0 ? x(values[i]) : kZero, up = height_of(kCurveShares[i]);
    path += path.empty() ? fmt::format("M{:.1f} {:.1f}", at, up) : fmt::format("H{:.1f}V{:.1f}", at, up);
    // Marks of different backends stand at different heights.
    if (i % 8 == static_cast<std::size_t>(place) % 8) marks += mark_at(place, at, up, false, 4.2);
  }
  return path.empty() ? "" : fmt::format("<path class='curve m{}' d='{}'/>", place, path) + marks;
}

// ---- signed errors

constexpr double kSide = 300, kMargin = 44, kArea = 222, kAreaTop = 28;
constexpr double kThreshold = 1e-17;
constexpr double kLargest = kMostShownError;  // two solids within S of the origin are nearer, 2 sqrt(3) S

std::string signed_axes(const SignedLogScale& x, const SignedLogScale& y) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kMargin,
                                kAreaTop, kArea, kArea);
  for (const double tick : {-1.0, -1e-8, 0.0, 1e-8, 1.0}) {
    const std::string label =
        tick == 0 ? "0" : (tick < 0 ? "-" : "") + (std::abs(tick) == 1.0 ? "1" : superscript(-8));
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}v{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4}</text>",
        x(tick), kAreaTop, kArea, kAreaTop + kArea + 16, label);
    svg += fmt::format(
        "<path class='grid' d='M{0} {1:.1f}h{2}'/><text x='{3}' y='{4:.1f}' text-anchor='end'>{5}</text>",
        kMargin, y(tick), kArea, kMargin - 5, y(tick) + 3.5, label);
  }
  svg += fmt::format("<path class='front' d='M{0:.1f} {1}v{2}M{3} {4:.1f}h{2}'/>", x(0), kAreaTop, kArea,
                     kMargin, y(0));
  return svg + fmt::format("<text x='{}' y='{}' text-anchor='middle'>true separation / S</text>",
                           kMargin + kArea / 2, kAreaTop + kArea + 32);
}

// A backend that answers no such query has no line.
bool has_line(const BackendResult& backend, std::size_t query) {
  return backend.judged && backend.judgement.cost[query].count > 0 &&
         backend.judgement.wrongness[query].unsupported < backend.judgement.wrongness[query].cases;
}

}  // namespace

Decades error_axis_for(std::span<const SetResult> sets, QueryKind query) {
  double least = 1, most = 0;
  for (const SetResult& set : sets) {
    for (const BackendResult& backend : set.backends) {
      if (!has_line(backend, index_of(query))) continue;
      for (const double value : backend.judgement.cost_curve[index_of(query)]) {
        if (!(value > 0) || !std::isfinite(value)) continue;
        least = std::min(least, std::max(value, kLeastShownError));
        most = std::max(most, std::min(value, kMostShownError));
      }
    }
  }
  return most == 0 ? Decades{-17, 0} : decades_around(least, most);
}

std::vector<std::string> distribution_lines(const SetResult& set, QueryKind query) {
  const std::size_t q = index_of(query);
  std::vector<const BackendResult*> lines;
  for (const BackendResult& backend : set.backends)
    if (has_line(backend, q)) lines.push_back(&backend);
  const auto without_answer = [&](const BackendResult* backend) {
    const Wrongness& wrong = backend->judgement.wrongness[q];
    return wrong.total() + wrong.unsupported;
  };
  std::stable_sort(lines.begin(), lines.end(), [&](const BackendResult* x, const BackendResult* y) {
    if (without_answer(x) != without_answer(y)) return without_answer(x) < without_answer(y);
    return x->judgement.cost[q].worst < y->judgement.cost[q].worst;
  });
  std::vector<std::string> names;
  for (const BackendResult* backend : lines) names.push_back(backend->name);
  return names;
}

std::string error_distribution_plot(const SetResult& set, QueryKind query, const Decades& axis,
                                    const std::vector<std::string>& backends, bool standalone,
                                    std::size_t most_lines) {
  const LogScale x = log_scale(axis, kAxisLeft + 4, kAxisRight - 4);
  std::vector<std::string> lines = distribution_lines(set, query);
  if (lines.size() > most_lines) lines.resize(most_lines);
  const double height = std::max(kHeight, kTop + kLegendStep * static_cast<double>(lines.size() + 1));
  std::string svg = svg_open(
      kWidth, height, fmt::format("{} {}: distribution of errors", set.name, to_string(query)), standalone);
  svg += fmt::format("<text class='title' x='{}' y='18'>{}, {}</text>", kLeft, xml_text(set.name),
                     to_string(query));
  svg += distribution_axes(x);
  for (const BackendResult& backend : set.backends) {
    if (std::find(lines.begin(), lines.end(), backend.name) == lines.end()) continue;
    svg += "<g><title>" + xml_text(backend.name) + "</title>" +
           distribution_line(backend.judgement.cost_curve[index_of(query)], x,
                             place_of(backends, backend.name)) +
           "</g>";
  }
  svg += plot_legend(lines, backends, kAxisRight + 18, kTop + 8);
  return svg + fmt::format("<text x='{}' y='{}' text-anchor='middle'>error / S at most</text></svg>\n",
                           (kAxisLeft + kAxisRight) / 2, kBottom + 36);
}

std::string signed_error_plot(std::span<const SetResult> sets, const std::string& backend,
                              const std::vector<std::string>& backends, bool standalone) {
  const SignedLogScale x{kThreshold, kLargest, kMargin, kMargin + kArea};
  const SignedLogScale y{kThreshold, kLargest, kAreaTop + kArea, kAreaTop};
  std::string dots, held;
  for (const SetResult& set : sets) {
    for (const BackendResult& result : set.backends) {
      if (result.name != backend || !result.judged) continue;
      for (const SignedError& each : result.judgement.signed_errors) {
        if (!std::isfinite(each.error)) continue;
        dots += fmt::format("M{:.0f} {:.0f}h0", x(each.separation), y(each.error));
        if (!y.reaches(each.error))
          held += held_mark(x(each.separation), y(each.error), 0, each.error > 0 ? -1 : 1);
      }
    }
  }
  if (dots.empty()) return "";
  const int place = place_of(backends, backend);
  std::string svg = svg_open(kSide, kSide, backend + ": error against true separation", standalone);
  svg += mark_at(place, kMargin + 6, 14, false) +
         fmt::format("<text class='title' x='{}' y='18'>{}</text>", kMargin + 18, xml_text(backend));
  svg += signed_axes(x, y);
  return svg + fmt::format("<path class='dots m{}' d='{}'/>", place, dots) + held + "</svg>\n";
}

}  // namespace touchstone::comparison
