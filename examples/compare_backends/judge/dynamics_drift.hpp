#pragma once

#include <string>
#include <vector>

namespace touchstone::comparison {

/// The effect of a backend's contacts on one scene with dynamics, as dynamics_run found it; NaN: not
/// measured.
struct DriftRun {
  std::string scene, backend;
  std::string gap;                  ///< why it was not run, or stopped; empty: it went through
  std::vector<std::string> misses;  ///< of the scene's limits, "ends 19 mm off"
  double pose_error = 0;            ///< of the final poses, from the reference's [m]
  double momentum = 0;              ///< that nothing explains [N s]
  double energy_made = 0;           ///< over the scene's energy scale; NaN also where that is 0
  double deepest = 0;               ///< worst penetration [m]
  double step_ns = 0;               ///< median
  double p999_ns = 0;
  double allocations = 0;  ///< of the whole run
  std::size_t answers = 0, met = 0;
  bool build_on = false;  ///< the backend that dynamics_run names for the scene

  bool is_within() const { return gap.empty() && misses.empty(); }
};

struct DriftScene {
  std::string name, build_on, reason;  ///< build_on empty: none, see reason
  bool touches = false;                ///< else there is nothing to choose a backend by
};

/// All that dynamics_run found.
struct Drift {
  std::vector<DriftRun> runs;
  std::vector<DriftScene> scenes;
  std::string build_on, reason;  ///< over all scenes; build_on empty: none, see reason
};

/// One backend's results over the scenes that touch: the worst of its completed runs, NaN without any.
struct DriftStanding {
  std::string backend;
  std::size_t scenes = 0, within = 0;  ///< of how many, within the limits of how many
  double pose_error, momentum, energy_made, deepest;
  double step_ns;       ///< geometric mean of the medians
  double p999_ns;       ///< largest
  double allocations;   ///< most, of a run
  std::string failure;  ///< why it is not within the limits of the first scene that it fails; empty: none
};
/// Every backend of the runs: those within the most scenes' limits first, then the faster.
std::vector<DriftStanding> drift_standings(const Drift& drift);

/// Whether the page's opening verdict and the one over dynamics agree, or which to build on instead and why,
/// in a sentence or two. @param headline the backend of the page's verdict; empty: it names none.
std::string drift_agreement(const Drift& drift, const std::string& headline);

}  // namespace touchstone::comparison
