#pragma once

#include <span>
#include <string>
#include <vector>

#include "examples/measures/broadphase_run.hpp"

namespace touchstone::comparison {

/// How a broadphase's frame grows with the number of boxes as SVG: log-log, one line a broadphase with its
/// fitted slope (least squares of the logarithms) at the end. @param backends gives the marks, as in
/// speed_error_plot().
std::string growth_plot(std::span<const BroadphaseResult> results, const std::vector<std::string>& backends,
                        bool standalone);

}  // namespace touchstone::comparison
