#include "touchstone/examples/dynamics_run/panel_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::dynamics {
namespace {

constexpr double kWidth = 760, kLeft = 84, kRight = 560, kTop = 52, kPanel = 120, kGap = 46, kBelow = 44;
constexpr std::size_t kPlaces = 400;  // along a panel
constexpr std::array<const char*, 5> kDashes = {"none", "7 4", "2 3", "9 3 2 3", "1 4"};
constexpr std::size_t kColours = 9;  // of plot_style()

struct Scale {
  double low, high, from, to;
  double operator()(double value) const { return from + (to - from) * (value - low) / (high - low); }
};

/// 1, 2 or 5 times a power of ten, about a `parts`-th of the range.
double step_for(double range, double parts) {
  const double power = std::pow(10.0, std::floor(std::log10(range / parts)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= range / parts) return factor * power;
  return 10.0 * power;
}

/// With room above and below; a line that does not move gets a range of its size.
Scale y_scale(const PlotPanel& panel, double top) {
  double low = 0.0, high = 0.0, largest = 0.0;
  bool any = false;
  for (const PlotLine& line : panel.lines)
    for (const double y : line.y) {
      if (!std::isfinite(y)) continue;
      low = any ? std::min(low, y) : y, high = any ? std::max(high, y) : y;
      largest = std::max(largest, std::abs(y));
      any = true;
    }
  const double least = largest > 0.0 ? 1e-6 * largest : 1.0;
  const double room = std::max(0.08 * (high - low), 0.5 * least);
  return {low - room, high + room, top + kPanel, top};
}

/// Multiples of `step` from low to high.
std::vector<double> marks(double low, double high, double step) {
  std::vector<double> out;
  const double first = std::ceil(low / step);
  const int count = static_cast<int>(std::floor((high - first * step) / step + 1e-9)) + 1;
  for (int i = 0; i < count; ++i) out.push_back((first + i) * step);
  return out;
}

std::string grid(const Scale& x, const Scale& y, bool is_last) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, y.to,
                                kRight - kLeft, kPanel);
  for (const double at : marks(x.low, x.high, step_for(x.high - x.low, 8))) {
    svg += fmt::format("<path class='grid' d='M{:.1f} {}V{}'/>", x(at), y.to, y.from);
    if (is_last)
      svg +=
          fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{:.6g}</text>", x(at), y.from + 16, at);
  }
  for (const double at : marks(y.low, y.high, step_for(y.high - y.low, 4)))
    svg += fmt::format(
        "<path class='grid' d='M{} {:.1f}H{}'/><text x='{}' y='{:.1f}' text-anchor='end'>{:.8g}</text>",
        kLeft, y(at), kRight, kLeft - 6, y(at) + 4, at);
  return svg;
}

std::string path_of(const PlotLine& line, const std::vector<double>& times, const Scale& x, const Scale& y) {
  std::string path;
  const std::size_t count = std::min(line.y.size(), times.size());
  const std::size_t each = std::max<std::size_t>(1, count / kPlaces);
  const auto add = [&](std::size_t i) {
    if (std::isfinite(line.y[i]))
      path += fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : "L", x(times[i]), y(line.y[i]));
  };
  for (std::size_t first = 0; first < count; first += each) {
    const auto begin = line.y.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = line.y.begin() + static_cast<std::ptrdiff_t>(std::min(count, first + each));
    const auto [least, largest] = std::minmax_element(begin, end);
    const auto a = static_cast<std::size_t>(least - line.y.begin()),
               b = static_cast<std::size_t>(largest - line.y.begin());
    add(std::min(a, b));
    if (a != b) add(std::max(a, b));
  }
  return path;
}

std::vector<std::string> names_of(const PlotPanel& panel) {
  std::vector<std::string> names;
  for (const PlotLine& line : panel.lines)
    if (std::find(names.begin(), names.end(), line.name) == names.end()) names.push_back(line.name);
  return names;
}

std::string draw(const PlotPanel& panel, const PanelPlot& plot, const Scale& x, double top, bool is_last) {
  const Scale y = y_scale(panel, top);
  std::string svg = grid(x, y, is_last);
  svg += fmt::format("<text class='small' x='{}' y='{}'>{}</text>", kLeft, top - 7,
                     program::xml_text(panel.title));
  const std::vector<std::string> names = names_of(panel);
  // The first backend on top, thinner than those that it may cover.
  for (std::size_t i = panel.lines.size(); i-- > 0;) {
    const PlotLine& line = panel.lines[i];
    const auto name =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), line.name) - names.begin());
    const double width = 1.3 + 0.9 * static_cast<double>(line.colour);
    svg += fmt::format(
        "<path d='{}' "
        "style='fill:none;stroke:var(--c{});stroke-width:{:.1f};stroke-dasharray:{}'/>",
        path_of(line, plot.times[line.colour], x, y), line.colour % kColours, width,
        kDashes[name % kDashes.size()]);
  }
  for (std::size_t n = 0; n < names.size() && !names[n].empty(); ++n) {
    const double at = top + 12 + 15 * static_cast<double>(n);
    svg += fmt::format(
        "<path d='M{} {:.1f}h26' style='fill:none;stroke:var(--ink);stroke-width:1.4;stroke-dasharray:{}'/>"
        "<text class='small' x='{}' y='{:.1f}'>{}</text>",
        kRight + 10, at - 4, kDashes[n % kDashes.size()], kRight + 42, at, program::xml_text(names[n]));
  }
  return svg;
}

std::string colour_legend(const PanelPlot& plot) {
  std::string svg;
  double at = kLeft;
  for (std::size_t i = 0; i < plot.colours.size(); ++i) {
    svg += fmt::format(
        "<path d='M{0:.0f} 32h18' style='stroke:var(--c{1});stroke-width:3'/><text class='label' x='{2:.0f}' "
        "y='36'>{3}</text>",
        at, i % kColours, at + 22, program::xml_text(plot.colours[i]));
    at += 40 + 6.5 * static_cast<double>(plot.colours[i].size());
  }
  return svg;
}

}  // namespace

std::string panel_plot(const PanelPlot& plot) {
  const auto count = static_cast<double>(plot.panels.size());
  const double height = kTop + 14 + count * kPanel + (count - 1) * kGap + kBelow;
  Scale x{0.0, 0.0, kLeft, kRight};
  for (const std::vector<double>& times : plot.times)
    if (!times.empty()) x.high = std::max(x.high, times.back());
  if (!(x.high > 0.0) || plot.panels.empty()) return "";
  std::string svg = fmt::format(
      "<svg class='plot' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}' "
      "role='img' aria-label='{2}: over time'><style>{3}</style>"
      "<rect width='{0}' height='{1}' style='fill:var(--paper)'/><text class='title' x='{4}' "
      "y='18'>{2}</text>",
      kWidth, height, program::xml_text(plot.title), program::plot_style(), kLeft);
  svg += colour_legend(plot);
  double top = kTop + 14;
  for (std::size_t i = 0; i < plot.panels.size(); ++i, top += kPanel + kGap)
    svg += draw(plot.panels[i], plot, x, top, i + 1 == plot.panels.size());
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>time [s]</text>", (kLeft + kRight) / 2,
                     height - 10);
  return svg + "</svg>\n";
}

}  // namespace touchstone::dynamics
