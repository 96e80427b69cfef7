#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/runs/broadphase_run.hpp"
#include "touchstone/examples/measures/runs/thread_run.hpp"
#include "touchstone/examples/program/plots/svg_plot.hpp"

namespace touchstone::comparison {

/// Along which a swarm grows: in objects of one hexahedron each, or in hexahedra an object.
enum class Growth { objects, hexahedra_each };

/// How a broadphase's frame grows as SVG: log-log, one line a broadphase with its fitted slope (least squares
/// of the logarithms, of kLeastForSlope points or more) at its end. Along hexahedra_each, the swarms of as
/// many objects as the fewest that have several count. A broadphase that missed a pair gets no speed mark,
/// but its count. Empty without any. @param backends gives the marks, as in speed_error_plot().
std::string growth_plot(std::span<const BroadphaseResult> results, Growth growth,
                        const std::vector<std::string>& backends, bool standalone);

/// Fewer points than this have no slope.
inline constexpr std::size_t kLeastForSlope = 3;
/// A line's slope: least squares of the logarithms.
struct FittedSlope {
  std::string along;  ///< "objects", "hexahedra an object", "threads"
  std::string name;
  double slope = 0;  ///< NaN of fewer than kLeastForSlope points
};
/// Of every line in the three plots, those without a speed mark left out.
std::vector<FittedSlope> fitted_slopes(std::span<const BroadphaseResult> broadphases,
                                       std::span<const ThreadResult> threads);

/// Time a pair against threads, log-log, one line a backend with its fitted slope (of kLeastForSlope counts
/// or more): -1 is perfect. At most `most_lines`: the fastest at their last count, those with a wrong answer
/// last.
std::string thread_plot(std::span<const ThreadResult> results, const std::vector<std::string>& backends,
                        bool standalone, std::size_t most_lines = kAllLines);
std::size_t thread_line_count(std::span<const ThreadResult> results);

}  // namespace touchstone::comparison
