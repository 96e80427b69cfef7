#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/figures/plot_scale.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {

/// The distributions' error axis [S]. Holds every line of error_distribution_plot() of every set.
Decades error_axis_for(std::span<const SetResult> sets, QueryKind query);

/// The distribution of a query's cost over S in one set, as SVG: the share of the pairs (up) whose error is
/// at most that (right, log), one line a backend with its marks along it. Exactly 0 has its own column left
/// of a broken axis. A line that ends below 1 has pairs without a figure. A legend stands beside it. Lines:
/// the first `most_lines` of distribution_lines().
std::string error_distribution_plot(const SetResult& set, QueryKind query, const Decades& axis,
                                    const std::vector<std::string>& backends, bool standalone,
                                    std::size_t most_lines = kAllLines);
/// The backends that have a line: those with the fewest wrong or missing answers first, of as few the one
/// with the least worst error.
std::vector<std::string> distribution_lines(const SetResult& set, QueryKind query);

/// One backend's separation error against the true separation, both over S and on signed logarithmic axes,
/// one dot a kept pair of every set: margins and tolerances show as shifted bands. An error above 10 S is
/// held at the edge with a held_mark(). Empty without any figure.
std::string signed_error_plot(std::span<const SetResult> sets, const std::string& backend,
                              const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
