#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/scenes/scene_run.hpp"

namespace touchstone::comparison {

/// A scene's commanded motion as SVG, one band a backend: free (empty), blocked (full, a tick through it),
/// wrongly blocked (low block), merged (high block, crosses): distinguished by height as well as by colour.
/// Empty without truth.
std::string timeline_plot(const SceneResult& scene, const std::vector<std::string>& backends,
                          bool standalone);

}  // namespace touchstone::comparison
