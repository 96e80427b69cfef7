#include "touchstone/examples/compare_backends/figures/time_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kWidth = 620, kLeft = 148, kRight = 520, kTop = 30, kRow = 40;

std::string mode_mark(std::size_t mode, double x, double y) {
  constexpr double r = 3.6;
  switch (mode) {
    case 0:
      return fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{}'/>", x, y, r);
    case 1:
      return fmt::format("<path d='M{:.1f} {:.1f}l4.4 4.4l-4.4 4.4l-4.4 -4.4z'/>", x, y - 4.4);
    case 2:
      return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{}' height='{}'/>", x - r, y - r, 2 * r, 2 * r);
    default:
      return fmt::format("<path d='M{:.1f} {:.1f}l4.4 7.6h-8.8z'/>", x, y - 4.6);
  }
}

using Modes = std::array<const std::optional<Timing>*, 4>;
Modes modes_of(const BackendResult::Rows& rows) {
  return {&rows.single, &rows.cached, &rows.batch, &rows.raw};
}

double line_end(const Timing& timing) {
  const double p99 = shown_p99(timing);
  return std::isnan(p99) ? timing.upper_quartile_ns : p99;
}

std::string held_ends(const Timing& timing, const LogScale& x, double y) {
  std::string svg;
  if (x.beyond(timing.minimum_ns) < 0) svg += held_mark(x(timing.minimum_ns), y, -1, 0);
  if (x.beyond(line_end(timing)) > 0) svg += held_mark(x(line_end(timing)), y, 1, 0);
  return svg;
}

std::string bar(const Timing& timing, std::size_t mode, int place, const LogScale& x, double y) {
  constexpr const char* kModes[] = {"single", "cached", "batch", "raw"};
  const double q1 = x(timing.lower_quartile_ns), q3 = x(timing.upper_quartile_ns);
  return fmt::format(
             "<g><title>{}: median {} ns, quartiles {} to {}, least {}, 99% {}, of {} blocks</title><path "
             "class='whisker m{}' d='M{:.1f} {:.1f}H{:.1f}'/><rect class='box m{}' x='{:.1f}' y='{:.1f}' "
             "width='{:.1f}' height='6'/><g class='m m{}'>{}</g></g>",
             kModes[mode], format_ns(timing.median_ns), format_ns(timing.lower_quartile_ns),
             format_ns(timing.upper_quartile_ns), format_ns(timing.minimum_ns), format_ns(shown_p99(timing)),
             timing.blocks, place, x(timing.minimum_ns), y, x(line_end(timing)), place, q1, y - 3,
             std::max(q3 - q1, 0.5), place, mode_mark(mode, x(timing.median_ns), y)) +
         held_ends(timing, x, y);
}

std::string time_axis(const LogScale& x, double bottom) {
  std::string svg = fmt::format("<rect class='area' x='{}' y='{}' width='{}' height='{}'/>", kLeft, kTop,
                                kRight - kLeft, bottom - kTop);
  for (int e = static_cast<int>(x.low); e <= static_cast<int>(x.high); ++e) {
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1}V{2:.1f}'/><text x='{0:.1f}' y='{3:.1f}' "
        "text-anchor='middle'>{4}</text>",
        x(std::pow(10.0, e)), kTop, bottom, bottom + 15, nanosecond_label(e));
  }
  return svg;
}

}  // namespace

Decades time_axis_for(std::span<const SetResult> sets) {
  double least = kInfinity, most = 0;
  for (const SetResult& set : sets) {
    for (const BackendResult& backend : set.backends) {
      for (std::size_t q = 0; q < 3; ++q) {
        if (!backend.is_complete(q)) continue;
        for (const std::optional<Timing>* timing : modes_of(backend.rows[q])) {
          if (!*timing || !((*timing)->minimum_ns > 0)) continue;
          least = std::min(least, (*timing)->minimum_ns);
          most = std::max(most, line_end(**timing));
        }
      }
    }
  }
  return most == 0 ? Decades{1, 5} : decades_around(least, most);
}

namespace {

// "3 of 6 wrong or open; 4 unsupported": as short as a plot's row is wide.
std::string no_speed_words(const Wrongness& wrong) {
  std::string text;
  if (wrong.total() > 0)
    text =
        fmt::format("{} of {} wrong or open", format_count(wrong.total()), format_count(wrong.supported()));
  if (wrong.unsupported > 0)
    text += fmt::format("{}{} unsupported", text.empty() ? "" : "; ", format_count(wrong.unsupported));
  return text;
}

}  // namespace

std::string time_plot(const SetResult& set, QueryKind query, const Decades& axis,
                      const std::vector<std::string>& backends, bool standalone) {
  const std::size_t q = index_of(query);
  // Each backend has a row, on the time axis of all sets.
  const double bottom = kTop + kRow * static_cast<double>(set.backends.size());
  const LogScale x = log_scale(axis, kLeft + 12, kRight - 12);
  std::string svg =
      svg_open(kWidth, bottom + 22, fmt::format("{} {}: distribution of times", set.name, to_string(query)),
               standalone);
  svg += fmt::format(
      "<text class='title' x='8' y='18'>{}, {}</text><text class='small' x='{}' y='22'>allocations</text>",
      xml_text(set.name), to_string(query), kRight + 12);
  svg += time_axis(x, bottom);
  double top = kTop;
  for (const BackendResult& backend : set.backends) {
    const int place = place_of(backends, backend.name);
    const bool wrong = !backend.is_complete(q);
    svg += mark_at(place, 14, top + kRow / 2, wrong);
    svg += fmt::format("<text class='label' x='26' y='{:.1f}'>{}</text>", top + kRow / 2 + 4,
                       xml_text(backend.name));
    const BackendResult::Rows& rows = backend.rows[q];
    const Modes modes = modes_of(rows);
    // Wrong answers have no speed: the row has a note instead.
    if (wrong) {
      svg += fmt::format("<text class='small' x='{}' y='{:.1f}'>{}: no speed</text>", kLeft + 10,
                         top + kRow / 2 + 4, no_speed_words(backend.judgement.wrongness[q]));
    }
    // The modes of a query lie below each other.
    for (std::size_t mode = 0; mode < 4 && !wrong; ++mode) {
      if (*modes[mode])
        svg += bar(**modes[mode], mode, place, x, top + 5.5 + 9.5 * static_cast<double>(mode));
    }
    // Allocations spoil a time's worst case, so they stand beside it.
    if (rows.allocations) {
      svg += fmt::format("<text class='small' x='{}' y='{:.1f}'>{:.3g}</text>", kRight + 12,
                         top + kRow / 2 + 4, *rows.allocations);
    }
    top += kRow;
  }
  return svg + "</svg>\n";
}

}  // namespace touchstone::comparison
