#pragma once

#include <functional>
#include <optional>
#include <string>

#include "touchstone/adapters/robots/robot.hpp"
#include "touchstone/contact_core/fit/fit.hpp"

namespace touchstone {

/// How meshes of robots are covered by fitted hexahedra.
struct FittedCoverOptions {
  double over = 0.0;  ///< no point of a cover is farther from the mesh's solid [m]; 0: `over_share`
  /// Of a mesh's size: the diagonal of its box along the axes, but no more than twice the middle side of
  /// that, so that a boom's error is not by its length.
  double over_share = 0.05;
  int repairs = FitOptions().repairs;  ///< see FitOptions
  /// Called with the mesh's name, a stage and how much of it is done, 0 to 1; may be empty. Not for meshes
  /// that were covered before.
  std::function<void(const std::string& mesh, std::string_view stage, double share)> progress = {};
  /// Called before a mesh is fitted; returns its cover from an earlier run, or none. May be empty.
  std::function<std::optional<Fit>(const TriangleMesh& mesh, const FitOptions& asked)> find = {};
  /// Called with a cover that was fitted anew, once `check` let it pass; may be empty.
  std::function<void(const TriangleMesh& mesh, const FitOptions& asked, const Fit& fit)> keep = {};
  /// Called with each new cover, found or fitted, before it is used; may be empty. What it throws ends the
  /// reading.
  std::function<void(const TriangleMesh& mesh, const Fit& fit, const std::string& name)> check = {};
};

/// A function for RobotOptions::cover_mesh: few hexahedra that hold the mesh, by fit_hexahedra(); the error
/// stated is the bound that the fit proved. Meshes that were covered before, equal to the bit, are not fitted
/// again: keep the function, or a copy, for all robots of a run. Not for several threads at once.
/// @throws InputError, naming the mesh: as fit_hexahedra().
CoverMesh fitted_cover(const FittedCoverOptions& options);

}  // namespace touchstone
