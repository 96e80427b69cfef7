#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// The figures' time axis [ns]. Holds all that time_plot() draws of the sets: every row from its least block
/// to the end of its line.
Decades time_axis_for(std::span<const SetResult> sets);

/// The distributions of one query's times in one set, as SVG: for each backend, single (circle), cached
/// (diamond), batch (square) and raw (triangle): the mark at the median, a box from the lower to the upper
/// quartile, a line from the least to the 99th percentile of the blocks' averages (of fewer than
/// kLeastForP99 blocks to the upper quartile); the allocations at the right. What lies beyond the axis is
/// held at its end with a held_mark(). A backend with a wrong or missing answer gets no speed mark: a hollow
/// mark and its count.
std::string time_plot(const SetResult& set, QueryKind query, const Decades& axis,
                      const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
