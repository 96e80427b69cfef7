#pragma once

#include <string>
#include <vector>

#include "examples/compare_backends/speed_error_plot.hpp"

namespace touchstone::comparison {

/// The distributions of one query's times in one set, as SVG: for each backend, single (circle), cached
/// (diamond), batch (square) and raw (triangle): the mark at the median, a box from the lower to the upper
/// quartile, a line from the least to the 99th percentile of the blocks' averages; the allocations at the
/// right. A backend with a wrong or missing answer gets no speed mark: a hollow mark and its count.
std::string time_plot(const SetResult& set, QueryKind query, const PlotAxes& axes,
                      const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
