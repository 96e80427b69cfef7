#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/training_run/results/results.hpp"

namespace touchstone::training {
namespace {

constexpr double kWidth = 640, kHeight = 330, kLeft = 66, kRight = 470, kTop = 46, kBottom = 284;
constexpr std::array<const char*, 4> kColours = {"--c2", "--c4", "--c6",
                                                 "--c0"};  // of the methods, in their order
constexpr std::array<const char*, 4> kDashes = {"7 4", "2 3", "10 3 2 3", "none"};

struct Scale {
  double low, high, from, to;
  double operator()(double value) const { return from + (to - from) * (value - low) / (high - low); }
};

/// 1, 2 or 5 times a power of ten, about an eighth of the range.
double step_for(double range) {
  const double power = std::pow(10.0, std::floor(std::log10(range / 8.0)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= range / 8.0) return factor * power;
  return 10.0 * power;
}

std::string grid(const Scale& x, const Scale& y) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, kTop,
                                kRight - kLeft, kBottom - kTop);
  const double dx = step_for(x.high - x.low), dy = step_for(y.high - y.low);
  for (double at = std::ceil(x.low / dx) * dx; at <= x.high + 1e-9 * dx; at += dx)
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2}'/><text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:.6g}"
        "</text>",
        x(at), kTop, kBottom, kBottom + 16, at);
  for (double at = std::ceil(y.low / dy) * dy; at <= y.high + 1e-9 * dy; at += dy)
    svg += fmt::format(
        "<path class='grid' d='M{} {:.1f}H{}'/><text x='{}' y='{:.1f}' text-anchor='end'>{:.6g}</text>",
        kLeft, y(at), kRight, kLeft - 6, y(at) + 4, std::abs(at) < 1e-9 * dy ? 0.0 : at);
  svg += fmt::format("<path d='M{} {:.1f}H{}' style='stroke:var(--ink);stroke-width:1'/>", kLeft, y(0.0),
                     kRight);
  svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>time [s]</text>", (kLeft + kRight) / 2,
                     kBottom + 36);
  return svg +
         fmt::format("<text class='small' x='{}' y='{:.1f}'>in contact below</text>", kLeft + 6, y(0.0) + 12);
}

std::string line(const MethodResult& method, std::size_t place, const Scale& x, const Scale& y) {
  std::string path;
  for (const SeparationPoint& point : method.separations)
    path +=
        fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : "L", x(point.time), y(1e3 * point.separation));
  return fmt::format("<path d='{}' style='fill:none;stroke:var({});stroke-width:2;stroke-dasharray:{}'/>",
                     path, kColours[place], kDashes[place]);
}

std::string length_text(double length) {
  if (std::abs(length) < 1e-6) return fmt::format("{:.3g} nm", 1e9 * length);
  if (std::abs(length) < 1e-4) return fmt::format("{:.3g} um", 1e6 * length);
  return fmt::format("{:.4g} mm", 1e3 * length);
}

std::string legend(const MethodResult& method, std::size_t place) {
  const double at = kTop + 14 + 40 * static_cast<double>(place);
  double least = method.separations[0].separation;
  for (const SeparationPoint& point : method.separations) least = std::min(least, point.separation);
  return fmt::format(
      "<path d='M{} {:.1f}h26' style='stroke:var({});stroke-width:2;stroke-dasharray:{}'/>"
      "<text class='label' x='{}' y='{:.1f}'>{}</text><text class='small' x='{}' y='{:.1f}'>{}{}</text>",
      kRight + 8, at - 4, kColours[place], kDashes[place], kRight + 40, at, program::xml_text(method.method),
      kRight + 40, at + 14, length_text(least), method.verdict.passed_through > 0 ? ", went through" : "");
}

}  // namespace

std::string separation_plot(const ScriptResult& result) {
  // No two methods share a colour.
  std::vector<const MethodResult*> methods;
  for (const MethodResult& method : result.methods)
    if (!method.separations.empty() && methods.size() < kColours.size()) methods.push_back(&method);
  if (methods.empty()) return "";
  // The y axis spans all separations, with some room.
  double low = 0.0, high = 0.0;
  for (const MethodResult* method : methods) {
    for (const SeparationPoint& point : method->separations) {
      low = std::min(low, 1e3 * point.separation);
      high = std::max(high, 1e3 * point.separation);
    }
  }
  const double room = 0.06 * (high - low);
  if (!(room > 0.0)) return "";
  const Scale x{methods[0]->separations.front().time, methods[0]->separations.back().time, kLeft, kRight};
  const Scale y{low - room, high + room, kBottom, kTop};
  // The file brings its style and background, since it is seen alone.
  std::string svg = fmt::format(
      "<svg class='plot' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}' "
      "role='img' aria-label='{2}: separation over time'><style>{3}</style>"
      "<rect width='{0}' height='{1}' style='fill:var(--paper)'/>",
      kWidth, kHeight, program::xml_text(result.file), program::plot_style());
  svg += fmt::format(
      "<text class='title' x='{0}' y='20'>{1}</text>"
      "<text class='small' x='{0}' y='37'>separation shown [mm], by exact; its least value beside each "
      "method</text>",
      kLeft, program::xml_text(result.setting->script().name));
  svg += grid(x, y);
  for (std::size_t i = 0; i < methods.size(); ++i) svg += line(*methods[i], i, x, y) + legend(*methods[i], i);
  return svg + "</svg>\n";
}

}  // namespace touchstone::training
