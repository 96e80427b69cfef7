#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/dynamics_drift.hpp"
#include "touchstone/examples/compare_backends/judge/ranking.hpp"

namespace touchstone::comparison {

/// The panels of drift_plot() that have no mark of a run that went through, as nothing finite was measured.
std::vector<std::string> missing_figures(const DriftRun& run);

/// Three panels: final poses, momentum and energy against the backend's worst error of a contact, one mark a
/// backend and scene, hollow where it is not within the scene's limits; a row above of the backends with a
/// run that did not end, a column on the right of those without a finite error of a contact. A legend beside
/// them counts the scenes within the limits.
/// @param rankings of which the manifold's gives the contact error. Empty without such, or runs.
std::string drift_plot(const Drift& drift, const std::vector<Ranking>& rankings,
                       const std::vector<std::string>& backends, bool standalone);

}  // namespace touchstone::comparison
