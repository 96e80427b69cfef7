#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/fit/fit_run.hpp"

// A cover to be looked at: a page and a glTF model.

namespace touchstone::fitting {

/// A fit of the same mesh within another error, for the plot of hexahedra against error.
struct CurvePoint {
  double over;   ///< asked [m]
  double error;  ///< of the fit [m]
  std::size_t hexahedra;
};

/// Fits within the run's error and twice, four and eight times as much, coarsest first; the run's own is
/// taken over. Errors without one are left out.
std::vector<CurvePoint> fit_curve(const FitRun& run, const FitRequest& request,
                                  program::ProgressLine& progress);

/// The distances of the cover's faces from the solid, on a grid of each face.
struct ExcessSurface {
  std::vector<Vector3> points;
  std::vector<double> excess;                           ///< a point: its distance to the solid [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside
};
/// About `most_triangles`, of at least two a face.
ExcessSurface excess_surface(const MeshDistance& solid, const Fit& fit, std::size_t most_triangles = 24000);

/// One HTML file that asks for nothing outside: mesh and cover in a picture that turns, excess as colours,
/// the worst places marked and listed, the curve as a plot. Light and dark, from a phone's width on.
/// @param solid of the run's mesh
std::string fit_page(const FitRun& run, const MeshDistance& solid, const ExcessSurface& surface,
                     const std::vector<CurvePoint>& curve);

/// glTF: the mesh, the cover with its excess as colours of the vertices, and a small box at each worst place.
std::string fit_gltf(const FitRun& run, const MeshDistance& solid, const ExcessSurface& surface);

}  // namespace touchstone::fitting
