#include "examples/compare_backends/growth_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "examples/compare_backends/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 560, kHeight = 320, kLeft = 60, kRight = 400, kTop = 30, kBottom = 270;

struct Point {
  double size, ms;
};

struct Line {
  std::string name;
  std::vector<Point> points;
};

struct LogScale {
  double low, high, from, to;  // powers of ten; pixels

  double operator()(double value) const {
    return from + (to - from) * (std::log10(value) - low) / (high - low);
  }
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
    const std::size_t size = growth == Growth::objects ? result.size.objects : result.size.hexahedra_each;
    line->points.push_back({static_cast<double>(size), result.frame.median_ns * 1e-6});
  }
  return lines;
}

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

std::string axis_lines(const LogScale& x, const LogScale& y, const std::string& size_label) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, kTop,
                                kRight - kLeft, kBottom - kTop);
  for (int decade = static_cast<int>(x.low); decade <= static_cast<int>(x.high); ++decade) {
    const double at = x(std::pow(10.0, decade));
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:.0f}"
        "</text>",
        at, kTop, kBottom, kBottom + 16, std::pow(10.0, decade));
  }
  for (int decade = static_cast<int>(y.low); decade <= static_cast<int>(y.high); ++decade) {
    const double at = y(std::pow(10.0, decade));
    svg += fmt::format(
        "<path class='grid' d='M{} {:.1f}H{}'/><text x='{}' y='{:.1f}' text-anchor='end'>{:g}</text>", kLeft,
        at, kRight, kLeft - 6, at + 4, std::pow(10.0, decade));
  }
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>", (kLeft + kRight) / 2, kBottom + 34,
                     xml_text(size_label));
  return svg + fmt::format("<text class='title' x='{}' y='18'>broadphases, ms a frame</text>", kLeft);
}

std::string placed_mark(const std::vector<std::string>& backends, const std::string& name, double x,
                        double y) {
  std::string svg = mark_svg(backends, name);
  return svg.replace(0, 4, fmt::format("<svg x='{:.1f}' y='{:.1f}'", x - 8, y - 8));
}

}  // namespace

std::string growth_plot(std::span<const BroadphaseResult> results, Growth growth,
                        const std::vector<std::string>& backends, bool standalone) {
  const std::vector<Line> lines = lines_of(results, growth);
  const std::string size_label =
      growth == Growth::objects ? "objects of one hexahedron"
                                : fmt::format("hexahedra each of {} objects", objects_of_several(results));
  if (lines.empty()) return "";
  double fewest = 1e300, most = 0, fastest = 1e300, slowest = 0;
  for (const Line& line : lines) {
    for (const Point& p : line.points) {
      fewest = std::min(fewest, p.size), most = std::max(most, p.size);
      fastest = std::min(fastest, p.ms), slowest = std::max(slowest, p.ms);
    }
  }
  const double last = std::max(std::ceil(std::log10(most)), std::floor(std::log10(fewest)) + 1);
  const LogScale x{std::floor(std::log10(fewest)), last, kLeft, kRight};
  const LogScale y{std::floor(std::log10(fastest)), std::floor(std::log10(slowest)) + 1, kBottom, kTop};
  std::string svg = fmt::format(
      "<svg class='plot' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}'{2} role='img' "
      "aria-label='broadphases: time against {3}'>",
      kWidth, kHeight, standalone ? fmt::format(" width='{}' height='{}'", kWidth, kHeight) : "",
      xml_text(size_label));
  if (standalone) {
    svg += "<style>" + plot_style() + "</style>";
    svg += fmt::format("<rect width='{}' height='{}' style='fill:var(--paper)'/>", kWidth, kHeight);
  }
  svg += axis_lines(x, y, size_label);
  std::vector<std::pair<double, std::string>> labels;  // by height
  for (const Line& line : lines) {
    std::string path;
    for (const Point& p : line.points)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(p.size), y(p.ms));
    svg += fmt::format("<path class='leader' style='fill:none;stroke-width:1.4' d='{}'/>", path);
    for (const Point& p : line.points) svg += placed_mark(backends, line.name, x(p.size), y(p.ms));
    const std::string slope_text =
        line.points.size() > 1 ? fmt::format(", slope {:.2f}", slope(line.points)) : std::string();
    labels.emplace_back(y(line.points.back().ms), line.name + slope_text);
  }
  std::sort(labels.begin(), labels.end());
  double free_from = 0;
  for (const auto& [at, text] : labels) {
    const double height = std::max(at + 4, free_from);
    svg +=
        fmt::format("<text class='label' x='{}' y='{:.1f}'>{}</text>", kRight + 10, height, xml_text(text));
    free_from = height + 14;
  }
  return svg + "</svg>\n";
}

}  // namespace touchstone::comparison
