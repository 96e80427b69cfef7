#include "touchstone/examples/compare_backends/figures/speed_error_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/compare_backends/judge/pareto_front.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

// ---- layout, in SVG units

constexpr double kWidth = 610, kHeight = 330;
constexpr double kLeft = 58, kTop = 34, kBottom = 286;  // of the plot area
constexpr double kZeroRight = 132;                      // the column of exactly 0
constexpr double kErrorLeft = 144, kErrorRight = 386;   // the error axis
constexpr double kRail = 412;                           // the rail's marks

// ---- axes

std::string draw_axes(const LogScale& x, const LogScale& y) {
  // Errors of exactly 0 have an area of their own.
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kErrorLeft, kTop,
                                kErrorRight - kErrorLeft, kBottom - kTop);
  svg += fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, kTop,
                     kZeroRight - kLeft, kBottom - kTop);
  // Times have a line for each power of ten.
  const int ns_low = static_cast<int>(std::lround(y.low)), ns_high = static_cast<int>(std::lround(y.high));
  for (int e = ns_low; e <= ns_high; ++e) {
    const double at = y(std::pow(10.0, e));
    svg += fmt::format("<path class='grid' d='M{} {:.1f}H{}M{} {:.1f}H{}'/>", kLeft, at, kZeroRight,
                       kErrorLeft, at, kErrorRight);
    svg += fmt::format("<text x='{}' y='{:.1f}' text-anchor='end'>{}</text>", kLeft - 6, at + 3.5,
                       nanosecond_label(e));
  }
  // Errors skip powers of ten, so that labels stay apart.
  const int e_low = static_cast<int>(std::lround(x.low)), e_high = static_cast<int>(std::lround(x.high));
  const int step = std::max(1, (e_high - e_low + 5) / 6);
  for (int e = e_high; e >= e_low; e -= step) {
    const double at = x(std::pow(10.0, e));
    svg += fmt::format("<path class='grid' d='M{0:.1f} {1}V{2}'/>", at, kTop, kBottom);
    svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{}</text>", at, kBottom + 17,
                       superscript(e));
  }
  // The logarithmic axis has no 0, so that it is broken before it.
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>0</text>", (kLeft + kZeroRight) / 2,
                     kBottom + 17);
  const double gap = (kZeroRight + kErrorLeft) / 2;
  svg += fmt::format("<path class='break' d='M{0:.1f} {2}l4 -9M{1:.1f} {2}l4 -9'/>", gap - 5, gap + 1,
                     kBottom + 4.5);
  return svg;
}

// ---- labels: the first place beside the mark that hits nothing

struct Box {
  double x0, y0, x1, y1;
  bool hits(const Box& other) const {
    return x0 < other.x1 && other.x0 < x1 && y0 < other.y1 && other.y0 < y1;
  }
};

class Labels {
 public:
  void block(const Box& box) { taken_.push_back(box); }

  std::string place(double x, double y, const std::string& text) {
    const double width = 5.9 * static_cast<double>(text.size());
    for (const double dy : {0.0, -12.0, 12.0, -22.0, 22.0, -33.0, 33.0, -44.0, 44.0}) {
      for (const bool right : {true, false}) {
        const double x0 = right ? x + 10 : x - 10 - width;
        const Box box{x0, y + dy - 6, x0 + width, y + dy + 5};
        if (box.x0 < kLeft + 1 || box.x1 > kErrorRight - 1 || box.y0 < kTop || box.y1 > kBottom) continue;
        if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) { return box.hits(other); }))
          continue;
        taken_.push_back(box);
        std::string svg;
        if (dy != 0.0) {
          svg = fmt::format("<path class='leader' d='M{:.1f} {:.1f}L{:.1f} {:.1f}'/>", x, y,
                            right ? x0 - 1 : box.x1 + 1, y + dy);
        }
        return svg + fmt::format("<text class='label' x='{:.1f}' y='{:.1f}'>{}</text>", x0, y + dy + 3.5,
                                 xml_text(text));
      }
    }
    return "";  // the shape and the legend still tell
  }

 private:
  std::vector<Box> taken_;
};

// ---- what is drawn

struct Mark {
  std::string name;
  int place;
  Quantiles error;
  Timing time;
};

struct RailEntry {
  std::string name;
  int place;
  std::string count;
};

// Wrongness in a few words: the largest kind.
std::string rail_text(const Wrongness& wrong) {
  const auto kinds = wrong.kinds();
  const auto& [count, name] = *std::max_element(
      kinds.begin(), kinds.end(), [](const auto& x, const auto& y) { return x.count < y.count; });
  std::string text = format_count(count) + " " + name;
  const std::size_t others = wrong.total() - count;
  if (others > 0) text += ", " + format_count(others) + " other";
  return text;
}

void sort_out(const SetResult& set, QueryKind query, const std::vector<std::string>& backends,
              std::vector<Mark>& marks, std::vector<RailEntry>& rail, std::vector<RailEntry>& unsupported) {
  const std::size_t q = index_of(query);
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    const int place = place_of(backends, backend.name);
    const Wrongness& wrong = backend.judgement.wrongness[q];
    const std::size_t not_supported = wrong.unsupported;
    if (wrong.total() > 0)
      rail.push_back({backend.name, place, rail_text(wrong)});
    else if (not_supported > 0)
      unsupported.push_back({backend.name, place, format_count(not_supported)});
    else if (!backend.rows[q].single)
      rail.push_back({backend.name, place, "not timed"});
    else
      marks.push_back({backend.name, place, backend.judgement.cost[q], *backend.rows[q].single});
  }
}

// Hollow what was wrong or gave no answer; below it, full, what does not support some of the pairs, and is
// not wrong.
std::string draw_rail(const std::vector<RailEntry>& rail, const std::vector<RailEntry>& unsupported) {
  constexpr double kFull = 29, kLine = 14, kHeading = 22;
  const double below = unsupported.empty() ? 0 : kHeading + kLine * static_cast<double>(unsupported.size());
  std::string svg;
  double y = kTop + 16;
  const double step =
      std::min(kFull, (kHeight - y - below) / static_cast<double>(std::max<std::size_t>(rail.size(), 1)));
  if (!rail.empty()) {
    svg += fmt::format(
        "<path class='rail' d='M{0} {1}V{2:.1f}'/><text class='small' x='{3}' y='{4}'>wrong or no answer: no "
        "speed</text>",
        kRail, kTop, y + step * static_cast<double>(rail.size() - 1), kRail - 12, kTop - 8);
  }
  // Wrong or silent backends.
  for (const RailEntry& entry : rail) {
    svg += mark_at(entry.place, kRail, y, true);
    svg += fmt::format("<text class='label' x='{}' y='{:.1f}'>{}</text>", kRail + 13, y + 0.5,
                       xml_text(entry.name));
    svg += fmt::format("<text class='small' x='{}' y='{:.1f}'>{}</text>", kRail + 13,
                       y + std::min(11.5, 0.48 * step), xml_text(entry.count));
    y += step;
  }
  if (unsupported.empty()) return svg;
  // Those that do not support some pairs.
  y = rail.empty() ? kTop - 8 : y + 2;
  svg += fmt::format("<text class='small' x='{}' y='{:.1f}'>pairs not supported: no speed</text>", kRail - 12,
                     y);
  for (const RailEntry& entry : unsupported) {
    y += kLine;
    svg += mark_at(entry.place, kRail, y, false, 4.0);
    svg += fmt::format("<text class='small' x='{}' y='{:.1f}'>{}: {}</text>", kRail + 13, y + 3.5,
                       xml_text(entry.name), entry.count);
  }
  return svg;
}

// Where in the column of 0 each mark stands: side by side where their times are too close to tell them apart.
std::vector<double> zero_columns(const std::vector<Mark>& marks, const LogScale& y) {
  std::vector<double> columns;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    double x = kLeft + 10;
    const double my = y(marks[i].time.median_ns);
    const auto taken = [&](double at) {
      for (std::size_t j = 0; j < i; ++j) {
        if (std::abs(columns[j] - at) < 12 && std::abs(y(marks[j].time.median_ns) - my) < 13) return true;
      }
      return false;
    };
    while (taken(x) && x + 13 < kZeroRight - 6) x += 13;
    columns.push_back(x);
  }
  return columns;
}

// Of what lies beyond an axis: the end it is held at.
std::string held_marks(double error, double ns, const LogScale& x, const LogScale& y, double mx, double my) {
  std::string svg;
  if (error > 0.0 && x.beyond(error) != 0) svg += held_mark(mx, my, x.beyond(error), 0);
  if (y.beyond(ns) != 0) svg += held_mark(mx, my, 0, -y.beyond(ns));
  return svg;
}

// The end of the whisker of times: the mark itself where there are too few blocks for a 99 %.
double whisker_end(const Timing& time) {
  const double p99 = shown_p99(time);
  return std::isnan(p99) ? time.median_ns : p99;
}

std::string draw_marks(const std::vector<Mark>& marks, const LogScale& x, const LogScale& y) {
  std::string whiskers, shapes, text;
  Labels labels;
  const std::vector<double> columns = zero_columns(marks, y);
  // Names keep clear of marks and whiskers.
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const double mx = marks[i].error.worst == 0.0 ? columns[i] : x(marks[i].error.worst),
                 my = y(marks[i].time.median_ns);
    labels.block({mx - 7, my - 7, mx + 7, my + 7});
    const double median_x = marks[i].error.median == 0.0 ? columns[i] : x(marks[i].error.median);
    labels.block({std::min(mx, median_x), my - 2, std::max(mx, median_x), my + 2});
    labels.block({mx - 2, y(whisker_end(marks[i].time)), mx + 2, my});
  }
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const Mark& each = marks[i];
    const double mx = each.error.worst == 0.0 ? columns[i] : x(each.error.worst), my = y(each.time.median_ns);
    const double median_x = each.error.median == 0.0 ? columns[i] : x(each.error.median);
    whiskers += fmt::format("<path class='whisker m{}' d='M{:.1f} {:.1f}H{:.1f}M{:.1f} {:.1f}V{:.1f}'/>",
                            each.place, median_x, my, mx, mx, my, y(whisker_end(each.time)));
    if (each.error.p99 > 0.0 && std::isfinite(each.error.p99)) {
      whiskers += fmt::format("<path class='whisker m{}' d='M{:.1f} {:.1f}v8'/>", each.place,
                              x(each.error.p99), my - 4);
    }
    shapes += fmt::format(
        "<g><title>{}: {} ns a pair (99% {}), worst error {} S, 99% {} S, median {} S</title>{}</g>",
        xml_text(each.name), format_ns(each.time.median_ns), format_ns(shown_p99(each.time)),
        format_error(each.error.worst), format_error(each.error.p99), format_error(each.error.median),
        mark_at(each.place, mx, my, false));
    shapes += held_marks(each.error.worst, each.time.median_ns, x, y, mx, my);
    text += labels.place(mx, my, each.name);
  }
  return whiskers + shapes + text;
}

// The front as a staircase: right of it and above, something is both faster and more exact.
std::string draw_front(const std::vector<Mark>& marks, const std::vector<std::string>& front,
                       const LogScale& x, const LogScale& y) {
  const std::vector<double> columns = zero_columns(marks, y);
  std::string path;
  for (const std::string& name : front) {
    for (std::size_t i = 0; i < marks.size(); ++i) {
      if (marks[i].name != name) continue;
      const double at = marks[i].error.worst == 0.0 ? columns[i] : x(marks[i].error.worst);
      const double height = y(marks[i].time.median_ns);
      path += path.empty() ? fmt::format("M{:.1f} {:.1f}", at, height)
                           : fmt::format("H{:.1f}V{:.1f}", at, height);
    }
  }
  return path.empty() ? "" : fmt::format("<path class='front' d='{}H{}'/>", path, kErrorRight);
}

}  // namespace

PlotAxes axes_for(std::span<const SetResult> sets) {
  double ns_low = 1e9, ns_high = 1, error_low = 1, error_high = 1e-16;
  for (const SetResult& set : sets) {
    for (const BackendResult& backend : set.backends) {
      for (std::size_t q = 0; q < 3; ++q) {
        if (!backend.judged || !backend.rows[q].single || !backend.judgement.wrongness[q].is_complete())
          continue;
        const Quantiles& error = backend.judgement.cost[q];
        ns_low = std::min(ns_low, backend.rows[q].single->median_ns);
        ns_high = std::max(ns_high, whisker_end(*backend.rows[q].single));
        for (const double value : {error.median, error.worst}) {
          if (value > 0.0 && std::isfinite(value)) {
            error_low = std::min(error_low, value);
            error_high = std::max(error_high, value);
          }
        }
      }
    }
  }
  const auto down = [](double value) { return std::pow(10.0, std::floor(std::log10(value))); };
  const auto up = [](double value) { return std::pow(10.0, std::ceil(std::log10(value))); };
  if (ns_low > ns_high) return {};
  return {down(ns_low), std::max(up(ns_high), 100 * down(ns_low)),
          std::max(down(error_low), kLeastShownError), std::clamp(up(error_high), 1e-12, kMostShownError)};
}

std::string speed_error_plot(const SetResult& set, QueryKind query, const PlotAxes& axes,
                             const std::vector<std::string>& backends, bool standalone) {
  std::vector<Mark> marks;
  std::vector<RailEntry> rail, unsupported;
  sort_out(set, query, backends, marks, rail, unsupported);
  const LogScale x{std::log10(axes.error_low), std::log10(axes.error_high), kErrorLeft + 8, kErrorRight - 8};
  const LogScale y{std::log10(axes.ns_low), std::log10(axes.ns_high), kBottom, kTop};
  std::string svg = svg_open(
      kWidth, kHeight, fmt::format("{} {}: speed against error", set.name, to_string(query)), standalone);
  svg += fmt::format("<text class='title' x='{}' y='18'>{}, {}</text>", kLeft, xml_text(set.name),
                     to_string(query));
  svg += draw_axes(x, y) + draw_rail(rail, unsupported) + draw_front(marks, pareto_front(set, query), x, y) +
         draw_marks(marks, x, y);
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>worst error / S</text>",
                     (kErrorLeft + kErrorRight) / 2, kBottom + 36);
  return svg + "</svg>\n";
}

}  // namespace touchstone::comparison
