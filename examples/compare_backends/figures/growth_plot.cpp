#include "touchstone/examples/compare_backends/figures/growth_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 640, kHeight = 320, kLeft = 60, kRight = 400, kTop = 30, kBottom = 270;
constexpr double kInset = 8;       // of the first and last size from the area's edges
constexpr double kLabelStep = 15;  // from one label to the next
constexpr double kLetter = 6.3;    // a label's letter, at most, of most fonts

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

// A line in pixels, and what stands beside its end.
struct Drawn {
  std::vector<std::pair<double, double>> at;
  std::string text;
  int place = 0;

  double end_x() const { return at.back().first; }
  double end_y() const { return at.back().second; }
};

std::string label_text(const Line& line) {
  return line.name + (has_slope(line) ? fmt::format(", slope {:.2f}", slope(line.points)) : std::string());
}

// Whether a line has a point in the box, by its points and 32 more between each two: pixels apart.
bool passes(const Drawn& line, double x0, double y0, double x1, double y1) {
  constexpr int kSteps = 32;
  for (std::size_t i = 0; i < line.at.size(); ++i) {
    const auto [from_x, from_y] = line.at[i];
    const auto [to_x, to_y] = line.at[std::min(i + 1, line.at.size() - 1)];
    for (int k = 0; k <= kSteps; ++k) {
      const double share = static_cast<double>(k) / kSteps;
      const double x = from_x + share * (to_x - from_x), y = from_y + share * (to_y - from_y);
      if (x > x0 && x < x1 && y > y0 && y < y1) return true;
    }
  }
  return false;
}

// Whether the label has room right of the end of its line, in the area and clear of every other line.
bool has_room_inside(const std::vector<Drawn>& lines, const Drawn& own) {
  const double x0 = own.end_x() + 9, x1 = x0 + kLetter * static_cast<double>(own.text.size());
  if (x1 > kRight - 4) return false;
  return std::none_of(lines.begin(), lines.end(), [&](const Drawn& other) {
    return &other != &own && (passes(other, x0 - 2, own.end_y() - 14, x1, own.end_y() + 14) ||
                              (std::abs(other.end_y() - own.end_y()) < kLabelStep && other.end_x() < x1));
  });
}

// Names and slopes at the lines' ends: inside where a line ends early with room beside it, else in a column
// on the right, each as near to its line as its neighbours let it, with a leader to where it ends.
std::string line_labels(const std::vector<Drawn>& lines, const std::vector<std::string>& without_speed) {
  std::string svg;
  std::vector<const Drawn*> column;
  // Inside where there is room.
  for (const Drawn& line : lines) {
    if (!has_room_inside(lines, line)) {
      column.push_back(&line);
      continue;
    }
    svg += fmt::format("<text class='label' x='{:.1f}' y='{:.1f}'>{}</text>", line.end_x() + 11,
                       line.end_y() + 4, xml_text(line.text));
  }
  // The others in the column, from top to bottom.
  std::stable_sort(column.begin(), column.end(),
                   [](const Drawn* x, const Drawn* y) { return x->end_y() < y->end_y(); });
  std::vector<double> wanted;
  for (const Drawn* line : column) wanted.push_back(line->end_y());
  const double low_end = kBottom - kLabelStep * static_cast<double>(without_speed.size());
  const std::vector<double> heights = spread(wanted, kLabelStep, kTop + 4, low_end);
  for (std::size_t i = 0; i < column.size(); ++i) {
    svg += fmt::format("<path class='leader' d='M{:.1f} {:.1f}H{:.1f}L{:.1f} {:.1f}'/>",
                       column[i]->end_x() + 7, column[i]->end_y(),
                       std::max(column[i]->end_x() + 7, kRight - 2), kRight + 10, heights[i]);
    svg += mark_at(column[i]->place, kRight + 17, heights[i], false, 4.5);
    svg += fmt::format("<text class='label' x='{}' y='{:.1f}'>{}</text>", kRight + 26, heights[i] + 4,
                       xml_text(column[i]->text));
  }
  // Below them, the backends without a speed.
  double y = (heights.empty() ? kTop : std::max(heights.back(), low_end)) + kLabelStep;
  for (const std::string& text : without_speed) {
    svg += fmt::format("<text class='label' x='{}' y='{:.1f}'>{}</text>", kRight + 10, y + 4, xml_text(text));
    y += kLabelStep;
  }
  return svg;
}

struct Axes {
  LogScale x, y;
};

// Along x from the first size to the last, in whole decades without ticks of its own, which this adds.
Axes axes_of(const std::vector<Line>& lines, Plot& plot) {
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
  return {{first, last, kLeft + kInset, kRight - kInset},
          {std::floor(std::log10(fastest)), std::floor(std::log10(slowest)) + 1, kBottom, kTop}};
}

// Those that are no backend's come after the backends: each line has a mark and a colour of its own.
std::vector<std::string> with_lines(std::vector<std::string> names, const std::vector<Line>& lines) {
  for (const Line& line : lines)
    if (std::find(names.begin(), names.end(), line.name) == names.end()) names.push_back(line.name);
  return names;
}

std::string line_plot(const std::vector<Line>& lines, Plot plot, const std::vector<std::string>& backends,
                      bool standalone) {
  if (lines.empty()) return "";
  const std::vector<std::string> names = with_lines(backends, lines);
  const auto [x, y] = axes_of(lines, plot);
  // Backends with wrong answers have no speed, and no line.
  std::vector<Drawn> drawn;
  std::vector<std::string> without_speed;
  for (const Line& line : lines) {
    if (line.wrong > 0) {
      without_speed.push_back(fmt::format("{}: {} wrong, no speed", line.name, format_count(line.wrong)));
      continue;
    }
    drawn.push_back({{}, label_text(line), place_of(names, line.name)});
    for (const Point& p : line.points) drawn.back().at.emplace_back(x(p.size), y(p.ms));
  }
  // The picture is as high as its labels need.
  const double height = std::max(
      kHeight, kTop + kLabelStep * static_cast<double>(drawn.size() + without_speed.size()) + 2 * kLabelStep);
  std::string svg = svg_open(kWidth, height, plot.title + " against " + plot.x_label, standalone);
  svg += axis_lines(x, y, plot);
  // Colour and mark of a line are those of its backend in all figures.
  for (const Drawn& line : drawn) {
    std::string path;
    for (const auto& [at_x, at_y] : line.at)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", at_x, at_y);
    svg += fmt::format("<path class='curve m{}' d='{}'/>", line.place, path);
    for (const auto& [at_x, at_y] : line.at) svg += mark_at(line.place, at_x, at_y, false);
  }
  return svg + line_labels(drawn, without_speed) + "</svg>\n";
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
      if (line.wrong == 0) slopes.push_back({along, line.name, has_slope(line) ? slope(line.points) : kNaN});
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
                        bool standalone, std::size_t most_lines) {
  std::vector<double> ticks;
  for (const ThreadResult& result : results) {
    if (std::find(ticks.begin(), ticks.end(), result.threads) == ticks.end()) ticks.push_back(result.threads);
  }
  std::vector<Line> lines = thread_lines(results);
  std::stable_sort(lines.begin(), lines.end(), [](const Line& x, const Line& y) {
    if ((x.wrong > 0) != (y.wrong > 0)) return y.wrong > 0;
    return x.points.back().ms < y.points.back().ms;
  });
  if (lines.size() > most_lines) lines.resize(most_lines);
  return line_plot(lines, {"distances in batches, ns a pair", "threads", ticks}, backends, standalone);
}

std::size_t thread_line_count(std::span<const ThreadResult> results) { return thread_lines(results).size(); }

}  // namespace touchstone::comparison
