#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/ranking.hpp"

namespace touchstone::comparison {

/// What a backend's contacts did to one scene with dynamics, as dynamics_run found it; NaN: not measured.
struct DriftRun {
  std::string scene, backend;
  std::string gap;         ///< why it was not run, or stopped; empty: it went through
  double pose_error = 0;   ///< of the final poses, from the reference's [m]
  double momentum = 0;     ///< that nothing explains [N s]
  double energy_made = 0;  ///< over the scene's energy scale; NaN also where that is 0
  double deepest = 0;      ///< worst penetration [m]
  double step_ns = 0;      ///< median
  std::size_t answers = 0, met = 0;
  bool build_on = false;  ///< the backend that dynamics_run names for the scene
};

/// From dynamics_run's results.json. @throws InputError for a file that is none, or where a figure is
/// negative that cannot be.
std::vector<DriftRun> load_drift(const std::string& path);

/// The panels of drift_plot() that have no mark of a run that went through, as nothing finite was measured.
std::vector<std::string> missing_figures(const DriftRun& run);

/// Three panels: final poses, momentum and energy against the backend's worst error of a contact, one mark a
/// backend and scene.
/// @param rankings of which the manifold's gives the contact error; backends without one are left out.
std::string drift_plot(const std::vector<DriftRun>& runs, const std::vector<Ranking>& rankings,
                       const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
