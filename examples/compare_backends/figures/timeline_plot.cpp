#include "touchstone/examples/compare_backends/figures/timeline_plot.hpp"

#include <fmt/format.h>

#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 760, kLeft = 150, kRight = 744, kTop = 30, kRow = 22, kBand = 14;

struct Span {
  char outcome;
  std::size_t begin, end;
};

std::vector<Span> spans_of(const std::string& outcomes) {
  std::vector<Span> spans;
  for (std::size_t f = 0; f < outcomes.size(); ++f) {
    if (spans.empty() || spans.back().outcome != outcomes[f]) spans.push_back({outcomes[f], f, f});
    spans.back().end = f + 1;
  }
  return spans;
}

const char* meaning(char outcome) {
  return outcome == 'b' ? "blocked" : outcome == 'w' ? "wrongly blocked" : outcome == 'm' ? "merged" : "free";
}

std::string block(const Span& span, double x0, double x1, double top) {
  const double width = std::max(x1 - x0, 1.0);
  std::string svg =
      fmt::format("<g><title>{}: frames {} to {}</title>", meaning(span.outcome), span.begin, span.end - 1);
  const double high = span.outcome == 'w' ? kBand * 0.45 : span.outcome == 'm' ? kBand * 1.3 : kBand;
  svg += fmt::format("<rect class='t-{}' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>",
                     span.outcome, x0, top + kBand - high, width, high);
  if (span.outcome == 'm' && width > 8) {
    for (double x = x0 + 3; x + 6 < x1; x += 14)
      svg +=
          fmt::format("<path class='tick' d='M{0:.1f} {1:.1f}l6 6m0 -6l-6 6'/>", x, top + kBand - high + 6);
  }
  return svg + "</g>";
}

}  // namespace

std::string timeline_plot(const SceneResult& scene, const std::vector<std::string>& backends,
                          bool standalone) {
  // Outcomes are known only where frames were judged by exact.
  const bool is_known = !scene.backends.empty() && !scene.backends.front().frame_outcomes.empty();
  if (!is_known) return "";
  // Time runs along x, and each backend has a row.
  const double bottom = kTop + kRow * static_cast<double>(scene.backends.size());
  const auto x = [&](std::size_t frame) {
    return kLeft + (kRight - kLeft) * static_cast<double>(frame) / static_cast<double>(scene.frames);
  };
  std::string svg = svg_open(kWidth, bottom + 22, scene.name + ": what each backend would block", standalone);
  svg += fmt::format("<text class='title' x='8' y='18'>{}</text>", xml_text(scene.name));
  double top = kTop;
  for (const SceneBackend& backend : scene.backends) {
    svg += mark_at(place_of(backends, backend.name), 14, top + kBand / 2, false);
    svg += fmt::format("<text class='label' x='26' y='{:.1f}'>{}</text>", top + kBand / 2 + 4,
                       xml_text(backend.name));
    // Frames that block are drawn over a band of free ones.
    svg += fmt::format("<rect class='t-free' x='{}' y='{:.1f}' width='{}' height='{}'/>", kLeft, top,
                       kRight - kLeft, kBand);
    for (const Span& span : spans_of(backend.frame_outcomes)) {
      if (span.outcome != '.') svg += block(span, x(span.begin), x(span.end), top);
    }
    top += kRow;
  }
  return svg + fmt::format(
                   "<text x='{}' y='{:.1f}'>0 s</text><text x='{}' y='{:.1f}' text-anchor='end'>{:.4g} s"
                   "</text></svg>\n",
                   kLeft, bottom + 14, kRight, bottom + 14, scene.duration);
}

}  // namespace touchstone::comparison
