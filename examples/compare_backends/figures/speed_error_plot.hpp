#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// The ranges of a plot's two axes.
struct PlotAxes {
  double ns_low = 10, ns_high = 1e5;         ///< powers of ten
  double error_low = 1e-17, error_high = 1;  ///< powers of ten
};

/// Axes that hold every mark of speed_error_plot() of every set; errors below 1e-20 S are held at its end.
PlotAxes axes_for(std::span<const SetResult> sets);

/// Speed against error of one pair set and query as SVG: log-log, one mark a backend at (worst error over S,
/// median ns a pair), whiskers from the median error (a tick at its 99th percentile) and to the 99th
/// percentile of time (none of fewer than kLeastForP99 blocks). Exactly 0 has its own column left of a broken
/// axis. A backend with any wrong, undecided, failed, unsupported or missing answer gets no speed mark: it
/// stands hollow on the rail at the right, in the report's order, with its count.
/// @param standalone with its own styles, legend colours for light and dark, and a title; otherwise for the
/// page, which brings plot_style().
std::string speed_error_plot(const SetResult& set, QueryKind query, const PlotAxes& axes,
                             const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
