#pragma once

#include <span>
#include <string>
#include <vector>

#include "examples/measures/broadphase_run.hpp"

namespace touchstone::comparison {

/// Along which a swarm grows: in objects of one hexahedron each, or in hexahedra an object.
enum class Growth { objects, hexahedra_each };

/// How a broadphase's frame grows as SVG: log-log, one line a broadphase with its fitted slope (least squares
/// of the logarithms) at the end. Along hexahedra_each, the swarms of as many objects as the fewest that have
/// several count. Empty without any. @param backends gives the marks, as in speed_error_plot().
std::string growth_plot(std::span<const BroadphaseResult> results, Growth growth,
                        const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
