#include "touchstone/examples/program/plots/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/examples/program/plots/plot_text.hpp"

namespace touchstone::program {
namespace {

// ---- marks: distinct shapes, Okabe and Ito's colours (plot.css, by the backend's place in the list)

constexpr int kShapes = 16;  // each with a colour of its own, as far as there are that many

std::string star(int points, double inner, double x, double y, double r) {
  std::string corners;
  for (int i = 0; i < 2 * points; ++i) {
    const double angle = M_PI * i / points, radius = i % 2 ? r * inner : r * 1.1;
    corners += fmt::format("{}{:.1f},{:.1f}", i ? " " : "", x + radius * std::sin(angle),
                           y - radius * std::cos(angle));
  }
  return fmt::format("<polygon points='{}'/>", corners);
}

std::string bar(double x, double y, double half_width, double half_height) {
  return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>", x - half_width,
                     y - half_height, 2 * half_width, 2 * half_height);
}

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
  // Outlines differ, so that backends are distinct without colours.
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
      return bar(x, y, r * 0.85, r * 0.85);
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
    case 8:
      return star(5, 0.45, x, y, r);
    case 9:
      return star(4, 0.35, x, y, r);
    case 10:
      return bar(x, y, r, r * 0.42);
    case 11:
      return bar(x, y, r * 0.42, r);
    case 12:  // an hourglass
      return fmt::format("<path d='M{:.1f} {:.1f}h{:.1f}l{:.1f} {:.1f}h{:.1f}z'/>", x - r * 0.85, y - r,
                         r * 1.7, -r * 1.7, 2 * r, r * 1.7);
    case 13:  // a cross on its corners
      return fmt::format(
          "<path transform='rotate(45 {0:.1f} {1:.1f})' d='M{2:.1f} "
          "{3:.1f}h{4:.1f}v{5:.1f}h{5:.1f}v{4:.1f}h{6:.1f}v{5:.1f}h{7:.1f}v{6:.1f}h{6:.1f}v{7:.1f}h{5:.1f}z'/"
          ">",
          x, y, x - r * 0.3, y - r, r * 0.6, r * 0.7, -r * 0.7, -r * 0.6);
    case 14:  // a square with a hole
      return fmt::format(
          "<path fill-rule='evenodd' d='M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}zm{:.1f} "
          "{:.1f}h{:.1f}v{:.1f}h{:.1f}z'/>",
          x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8, -r * 1.8, r * 0.6, r * 0.6, r * 0.6, r * 0.6, -r * 0.6);
    default:  // the lower half of a disc
      return fmt::format("<path d='M{:.1f} {:.1f}h{:.1f}a{:.1f} {:.1f} 0 0 1 {:.1f} 0z'/>", x - r,
                         y - r * 0.5, 2 * r, r, r, -2 * r);
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

std::string held_mark(double x, double y, int dx, int dy) {
  constexpr double from = 5, wide = 3.5, tip = 9;
  return fmt::format(
      "<path class='held' d='M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}'><title>further out than the axis "
      "reaches</title></path>",
      x + from * dx - wide * dy, y + from * dy - wide * dx, x + tip * dx, y + tip * dy,
      x + from * dx + wide * dy, y + from * dy + wide * dx);
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
  if (exponent < 0) return fmt::format("{:g} ns", std::pow(10.0, exponent));
  if (exponent > 9) return fmt::format("{:g} s", std::pow(10.0, exponent - 9));
  return kLabels[static_cast<std::size_t>(exponent)];
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

std::string plot_style() { return std::string(plot_text("plot.css")); }

std::string plot_legend(const std::vector<std::string>& names, const std::vector<std::string>& backends,
                        double x, double y) {
  std::string svg;
  for (const std::string& name : names) {
    svg += mark_at(place_of(backends, name), x, y, false, 5.0) +
           fmt::format("<text class='label' x='{:.1f}' y='{:.1f}'>{}</text>", x + 11, y + 4, xml_text(name));
    y += kLegendStep;
  }
  return svg;
}

std::vector<double> spread(std::vector<double> wanted, double gap, double low, double high) {
  // Less i gaps, heights that rise by a gap at least need only not fall: pool adjacent violators.
  struct Block {
    double sum;
    std::size_t count;
    double mean() const { return sum / static_cast<double>(count); }
  };
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    blocks.push_back({wanted[i] - gap * static_cast<double>(i), 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean() > blocks.back().mean()) {
      blocks[blocks.size() - 2].sum += blocks.back().sum;
      blocks[blocks.size() - 2].count += blocks.back().count;
      blocks.pop_back();
    }
  }
  const double last = std::max(low, high - gap * static_cast<double>(wanted.size() - 1));
  std::size_t i = 0;
  for (const Block& block : blocks) {
    for (std::size_t k = 0; k < block.count; ++k, ++i)
      wanted[i] = std::clamp(block.mean(), low, last) + gap * static_cast<double>(i);
  }
  return wanted;
}

std::string mark_svg(const std::vector<std::string>& backends, const std::string& backend) {
  return "<svg class='plot key' width='16' height='16' viewBox='0 0 16 16' aria-hidden='true'>" +
         mark_at(place_of(backends, backend), 8, 8, false) + "</svg>";
}

}  // namespace touchstone::program
