#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/gallery.hpp"

namespace touchstone::comparison {

/// A gallery case as SVG: A's edges solid, B's dashed, seen along a direction perpendicular to the exact
/// normal, which lies level (A to B: left to right) and is the thick arrow; each backend's normal is a thin
/// arrow with its mark at the tip, as long as it lies in the picture's plane.
std::string wireframe_plot(const GalleryCase& shown, const std::vector<std::string>& backends,
                           bool standalone);

}  // namespace touchstone::comparison
