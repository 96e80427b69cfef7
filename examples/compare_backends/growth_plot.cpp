#include "touchstone/examples/compare_backends/growth_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/examples/compare_backends/plot_scale.hpp"
#include "touchstone/examples/compare_backends/svg_plot.hpp"
#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 640, kHeight = 320, kLeft = 60, kRight = 400, kTop = 30, kBottom = 270;

struct Point {
  double size, ms;
};

struct Line {
  std::string name;
  std::vector<Point> points;
  std::size_t wrong = 0;  // not 0: no speed mark
};

struct Plot {
  std::string title, x_label;
  std::vector<double> x_ticks;  // empty: powers of ten
};

// Objects of the swarms that grow in hexahedra; 0: there are none.
std::size_t objects_of_several(std::span<const BroadphaseResult> results) {
  std::size_t objects = 0;
  for (const BroadphaseResult& result : results)
    if (result.size.hexahedra_each > 1 && (objects == 0 || result.size.objects < objects))
      objects = result.size.objects;
  return objects;
}

std::vector<Line> lines_of(std::span<const BroadphaseResult> results, Growth growth) {
  const std::size_t objects = objects_of_several(results);
  std::vector<Line> lines;
  for (const BroadphaseResult& result : results) {
    const bool belongs =
        growth == Growth::objects ? result.size.hexahedra_each == 1 : result.size.objects == objects;
    if (!result.gap.empty() || !belongs) continue;
    auto line =
        std::find_if(lines.begin(), lines.end(), [&](const Line& l) { return l.name == result.name; });
    if (line == lines.end()) line = lines.insert(lines.end(), {result.name, {}});
    line->wrong += result.missed.value_or(0);
    const std::size_t size = growth == Growth::objects ? result.size.objects : result.size.hexahedra_each;
    line->points.push_back({static_cast<double>(size), result.frame.median_ns * 1e-6});
  }
  return lines;
}

// A straight line through two points fits always: it is no measure of growth.
bool has_slope(const Line& line) { return line.wrong == 0 && line.points.size() >= kLeastForSlope; }

/// d log(ms) / d log(size).
double slope(const std::vector<Point>& points) {
  double x_mean = 0, y_mean = 0, xx = 0, xy = 0;
  const double count = static_cast<double>(points.size());
  for (const Point& p : points) x_mean += std::log(p.size) / count, y_mean += std::log(p.ms) / count;
  for (const Point& p : points) {
    const double x = std::log(p.size) - x_mean;
    xx += x * x, xy += x * (std::log(p.ms) - y_mean);
  }
  return xy / xx;
}

std::string axis_lines(const LogScale& x, const LogScale& y, const Plot& plot) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, kTop,
                                kRight - kLeft, kBottom - kTop);
  for (const double size : plot.x_ticks) {
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:.0f}"
        "</text>",
        x(size), kTop, kBottom, kBottom + 16, size);
  }
  for (int decade = static_cast<int>(y.low); decade <= static_cast<int>(y.high); ++decade) {
    const double at = y(std::pow(10.0, decade));
    svg += fmt::format(
        "<path class='grid' d='M{} {:.1f}H{}'/><text x='{}' y='{:.1f}' text-anchor='end'>{:g}</text>", kLeft,
        at, kRight, kLeft - 6, at + 4, std::pow(10.0, decade));
  }
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>", (kLeft + kRight) / 2, kBottom + 34,
                     xml_text(plot.x_label));
  return svg + fmt::format("<text class='title' x='{}' y='18'>{}</text>", kLeft, xml_text(plot.title));
}

// Names and slopes at the lines' ends, apart from each other.
std::string line_labels(const std::vector<Line>& lines, const LogScale& y) {
  std::vector<std::pair<double, std::string>> labels;  // by height
  for (const Line& line : lines) {
    if (line.wrong > 0) {
      labels.emplace_back(kBottom,
                          fmt::format("{}: {} wrong, no speed", line.name, format_count(line.wrong)));
      continue;
    }
    const std::string slope_text =
        has_slope(line) ? fmt::format(", slope {:.2f}", slope(line.points)) : std::string();
    labels.emplace_back(y(line.points.back().ms), line.name + slope_text);
  }
  std::sort(labels.begin(), labels.end());
  std::string svg;
  double free_from = 0;
  for (const auto& [at, text] : labels) {
    const double height = std::max(at + 4, free_from);
    svg +=
        fmt::format("<text class='label' x='{}' y='{:.1f}'>{}</text>", kRight + 10, height, xml_text(text));
    free_from = height + 14;
  }
  return svg;
}

std::string line_plot(const std::vector<Line>& lines, Plot plot, const std::vector<std::string>& backends,
                      bool standalone) {
  if (lines.empty()) return "";
  double fewest = 1e300, most = 0, fastest = 1e300, slowest = 0;
  for (const Line& line : lines) {
    for (const Point& p : line.points) {
      fewest = std::min(fewest, p.size), most = std::max(most, p.size);
      fastest = std::min(fastest, p.ms), slowest = std::max(slowest, p.ms);
    }
  }
  const double first = plot.x_ticks.empty() ? std::floor(std::log10(fewest)) : std::log10(fewest);
  const double last = plot.x_ticks.empty() ? std::max(std::ceil(std::log10(most)), first + 1)
                                           : std::max(std::log10(most), first + 0.3);
  if (plot.x_ticks.empty()) {
    for (int e = static_cast<int>(first); e <= last; ++e) plot.x_ticks.push_back(std::pow(10.0, e));
  }
  const double inset = 8;
  const LogScale x{first, last, kLeft + inset, kRight - inset};
  const LogScale y{std::floor(std::log10(fastest)), std::floor(std::log10(slowest)) + 1, kBottom, kTop};
  std::string svg = svg_open(kWidth, kHeight, plot.title + " against " + plot.x_label, standalone);
  svg += axis_lines(x, y, plot);
  for (const Line& line : lines) {
    if (line.wrong > 0) continue;
    std::string path;
    for (const Point& p : line.points)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(p.size), y(p.ms));
    const int place = place_of(backends, line.name);
    svg += fmt::format("<path class='curve m{}' d='{}'/>", place, path);
    for (const Point& p : line.points) svg += mark_at(place, x(p.size), y(p.ms), false);
  }
  return svg + line_labels(lines, y) + "</svg>\n";
}

std::vector<Line> thread_lines(std::span<const ThreadResult> results) {
  std::vector<Line> lines;
  for (const ThreadResult& result : results) {
    if (!result.gap.empty()) continue;
    if (lines.empty() || lines.back().name != result.backend)
      lines.push_back({result.backend, {}, result.wrong});
    lines.back().points.push_back({static_cast<double>(result.threads), result.pass.median_ns});
  }
  return lines;
}

}  // namespace

std::vector<FittedSlope> fitted_slopes(std::span<const BroadphaseResult> broadphases,
                                       std::span<const ThreadResult> threads) {
  std::vector<FittedSlope> slopes;
  const auto add = [&](const char* along, const std::vector<Line>& lines) {
    for (const Line& line : lines) {
      if (line.wrong == 0)
        slopes.push_back({along, line.name,
                          has_slope(line) ? slope(line.points) : std::numeric_limits<double>::quiet_NaN()});
    }
  };
  add("objects", lines_of(broadphases, Growth::objects));
  add("hexahedra an object", lines_of(broadphases, Growth::hexahedra_each));
  add("threads", thread_lines(threads));
  return slopes;
}

std::string growth_plot(std::span<const BroadphaseResult> results, Growth growth,
                        const std::vector<std::string>& backends, bool standalone) {
  const std::string size_label =
      growth == Growth::objects ? "objects of one hexahedron"
                                : fmt::format("hexahedra each of {} objects", objects_of_several(results));
  return line_plot(lines_of(results, growth), {"broadphases, ms a frame", size_label, {}}, backends,
                   standalone);
}

std::string thread_plot(std::span<const ThreadResult> results, const std::vector<std::string>& backends,
                        bool standalone) {
  std::vector<double> ticks;
  for (const ThreadResult& result : results) {
    if (std::find(ticks.begin(), ticks.end(), result.threads) == ticks.end()) ticks.push_back(result.threads);
  }
  return line_plot(thread_lines(results), {"distances in batches, ns a pair", "threads", ticks}, backends,
                   standalone);
}

}  // namespace touchstone::comparison
