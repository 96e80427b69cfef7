#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/fitted/total_error.hpp"

namespace touchstone::comparison {

/// The measurements of one mesh.
struct FittedMesh {
  std::string name;  ///< of the file
  std::size_t triangles = 0;
  double diagonal = 0.0;  ///< [m]
  double side = 0.0;      ///< of the probe [m]
  double range = 0.0;     ///< [m]
  std::size_t poses = 0;
  TotalErrors errors;
};

/// One table, for a terminal.
std::string fitted_text(const FittedMesh& mesh);
/// Markdown: how to read it, then for each mesh the table, and where there are times the cheapest by allowed
/// error and the plot's name.
/// @param failed why other meshes have no figures, a line each.
std::string fitted_page(const std::vector<FittedMesh>& meshes, const std::string& command,
                        const std::vector<std::string>& failed = {});
/// Time a frame against total error as SVG, log-log: one line a backend, its marks the covers. Empty: nothing
/// has a time and an error to draw.
std::string fitted_plot(const FittedMesh& mesh);
/// The plot's file, of the mesh's place in the page.
std::string fitted_plot_name(std::size_t mesh);

}  // namespace touchstone::comparison
