#include "examples/compare_backends/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone::comparison {
namespace {

// ---- marks: distinct shapes, Okabe and Ito's colours (as CSS classes, by the backend's place in the list)

constexpr int kShapes = 9;

std::string mark_path(int shape, double x, double y, double r) {
  const auto polygon = [&](int corners, double turn) {
    std::string points;
    for (int i = 0; i < corners; ++i) {
      const double angle = turn + 2.0 * M_PI * i / corners;
      points +=
          fmt::format("{}{:.1f},{:.1f}", i ? " " : "", x + r * std::sin(angle), y - r * std::cos(angle));
    }
    return fmt::format("<polygon points='{}'/>", points);
  };
  switch (shape) {
    case 0:
      return fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}'/>", x, y, r * 0.95);
    case 1:  // a cross with filled arms
      return fmt::format(
          "<path d='M{0:.1f} "
          "{1:.1f}h{2:.1f}v{3:.1f}h{3:.1f}v{2:.1f}h{4:.1f}v{3:.1f}h{5:.1f}v{4:.1f}h{4:.1f}v{5:.1f}h{3:.1f}z'/"
          ">",
          x - r * 0.35, y - r, r * 0.7, r * 0.65, -r * 0.65, -r * 0.7);
    case 2:
      return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>", x - r * 0.85,
                         y - r * 0.85, r * 1.7, r * 1.7);
    case 3:
      return polygon(4, 0.0);
    case 4:
      return polygon(5, 0.0);
    case 5:
      return polygon(3, 0.0);
    case 6:
      return polygon(3, M_PI);
    case 7:
      return polygon(6, 0.5);
    default: {  // a star
      std::string points;
      for (int i = 0; i < 10; ++i) {
        const double angle = M_PI * i / 5, radius = i % 2 ? r * 0.45 : r * 1.1;
        points += fmt::format("{}{:.1f},{:.1f}", i ? " " : "", x + radius * std::sin(angle),
                              y - radius * std::cos(angle));
      }
      return fmt::format("<polygon points='{}'/>", points);
    }
  }
}

}  // namespace

int place_of(const std::vector<std::string>& backends, const std::string& backend) {
  return static_cast<int>(std::find(backends.begin(), backends.end(), backend) - backends.begin()) % kShapes;
}

std::string mark_at(int place, double x, double y, bool hollow, double radius) {
  return fmt::format("<g class='m m{}{}'>{}</g>", place, hollow ? " hollow" : "",
                     mark_path(place, x, y, radius));
}

std::string svg_open(double width, double height, const std::string& label, bool standalone) {
  std::string svg = fmt::format(
      "<svg class='plot' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}'{2} role='img' "
      "aria-label='{3}'>",
      width, height, standalone ? fmt::format(" width='{}' height='{}'", width, height) : "",
      xml_text(label));
  if (standalone) {
    svg += "<style>" + plot_style() + "</style>";
    svg += fmt::format("<rect width='{}' height='{}' style='fill:var(--paper)'/>", width, height);
  }
  return svg;
}

std::string superscript(int exponent) {
  return fmt::format("10<tspan dy='-5' font-size='8'>{}</tspan>", exponent);
}

std::string nanosecond_label(int exponent) {
  constexpr std::array<const char*, 10> kLabels = {"1 ns",   "10 ns", "100 ns", "1 us",   "10 us",
                                                   "100 us", "1 ms",  "10 ms",  "100 ms", "1 s"};
  return kLabels[static_cast<std::size_t>(std::clamp(exponent, 0, 9))];
}

std::string xml_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (c == '\'')
      escaped += "&#39;";
    else
      escaped += c;
  }
  return escaped;
}

std::string plot_style() {
  return R"(.plot{--ink:#1b1f24;--soft:#5b6470;--line:#d5dae0;--area:#f7f8fa;--paper:#ffffff;
--c0:#0072b2;--c1:#7a7a7a;--c2:#d55e00;--c3:#b07c00;--c4:#00835d;--c5:#222222;--c6:#b3508a;--c7:#2f8fc4;--c8:#8a6d00}
@media (prefers-color-scheme: dark){.plot{--ink:#e8eaed;--soft:#a3abb5;--line:#3a414a;--area:#1d2126;--paper:#14171a;
--c0:#4db2ec;--c1:#b5b5b5;--c2:#ff8a3d;--c3:#e9b949;--c4:#2fc79a;--c5:#f5f5f5;--c6:#e893c3;--c7:#8fd0f5;--c8:#d9c35a}}
@media print{.plot{--ink:#000;--soft:#444;--line:#ccc;--area:#fff;--paper:#fff}}
.plot text{font:11px system-ui,sans-serif;fill:var(--soft)}.plot .label{fill:var(--ink);stroke:var(--area);stroke-width:4;stroke-linejoin:round;paint-order:stroke}
.plot .small{font-size:10px}.plot .title{font-size:13px;font-weight:600;fill:var(--ink)}
.plot .area{fill:var(--area);stroke:var(--line)}.plot .grid{stroke:var(--line);stroke-width:.7;fill:none}
.plot .front{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:5 4;fill:none}.plot .rail{stroke:var(--soft);stroke-dasharray:2 3}.plot .break{stroke:var(--soft);fill:none}
.plot .leader{stroke:var(--soft);stroke-width:.6}.plot .whisker{fill:none;stroke-width:1.6;opacity:.55}
.plot .m{stroke-width:1.6;paint-order:stroke;stroke:var(--paper)}.plot .hollow{fill:var(--paper)!important}
.plot .m0{fill:var(--c0)}.plot .m1{fill:var(--c1)}.plot .m2{fill:var(--c2)}.plot .m3{fill:var(--c3)}.plot .m4{fill:var(--c4)}
.plot .m5{fill:var(--c5)}.plot .m6{fill:var(--c6)}.plot .m7{fill:var(--c7)}.plot .m8{fill:var(--c8)}
.plot .whisker.m0,.plot .hollow.m0{stroke:var(--c0)}.plot .whisker.m1,.plot .hollow.m1{stroke:var(--c1)}
.plot .whisker.m2,.plot .hollow.m2{stroke:var(--c2)}.plot .whisker.m3,.plot .hollow.m3{stroke:var(--c3)}
.plot .whisker.m4,.plot .hollow.m4{stroke:var(--c4)}.plot .whisker.m5,.plot .hollow.m5{stroke:var(--c5)}
.plot .whisker.m6,.plot .hollow.m6{stroke:var(--c6)}.plot .whisker.m7,.plot .hollow.m7{stroke:var(--c7)}
.plot .whisker.m8,.plot .hollow.m8{stroke:var(--c8)}.plot .whisker{fill:none!important}
.plot .box{stroke:none;opacity:.45}.plot .curve{fill:none!important;stroke-width:1.6;stroke-linejoin:round}
.plot .dots{fill:none!important;stroke-width:3.4;stroke-linecap:round;opacity:.6}
.plot .curve.m0,.plot .dots.m0{stroke:var(--c0)}.plot .curve.m1,.plot .dots.m1{stroke:var(--c1)}.plot .curve.m2,.plot .dots.m2{stroke:var(--c2)}
.plot .curve.m3,.plot .dots.m3{stroke:var(--c3)}.plot .curve.m4,.plot .dots.m4{stroke:var(--c4)}.plot .curve.m5,.plot .dots.m5{stroke:var(--c5)}
.plot .curve.m6,.plot .dots.m6{stroke:var(--c6)}.plot .curve.m7,.plot .dots.m7{stroke:var(--c7)}.plot .curve.m8,.plot .dots.m8{stroke:var(--c8)}
.plot .solid-a{fill:none;stroke:var(--c0);stroke-width:1.3}.plot .solid-b{fill:none;stroke:var(--c2);stroke-width:1.3;stroke-dasharray:5 2.5}
.plot .exact{stroke:var(--ink);stroke-width:2.4;fill:none}.plot .arrow{stroke-width:1.8;fill:none}
.plot .t-free{fill:var(--area);stroke:var(--line)}.plot .t-b{fill:var(--c0)}.plot .t-w{fill:var(--c3)}.plot .t-m{fill:var(--c2)}.plot .tick{stroke:var(--paper);stroke-width:1.4;fill:none}
)";
}

std::string mark_svg(const std::vector<std::string>& backends, const std::string& backend) {
  return "<svg class='plot key' width='16' height='16' viewBox='0 0 16 16' aria-hidden='true'>" +
         mark_at(place_of(backends, backend), 8, 8, false) + "</svg>";
}

}  // namespace touchstone::comparison
