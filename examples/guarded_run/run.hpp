#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/guard_file.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"

namespace touchstone::guarded {

/// The paper's limits: what a trainee notices, and a frame at 50 Hz [us].
inline constexpr double kNoticed = 150e3, kFrameAt50Hz = 20e3;

/// One frame's end.
struct Sample {
  double time;
  Vector3 asked_W, hand_W;  ///< of the first hand's point: where its rates would have led, where it is [m]
  double force;             ///< of dynamics' contacts on its link, mean over the frame, magnitude [N]
  double torque_share;      ///< the largest of any joint's torque over its limit, in the frame
  double separation;        ///< least shown in the frame; NaN: nothing within the margin [m]
  double impulse;           ///< of cuts, in the frame [N s]
};

/// A scene run with one narrowphase behind the dynamics' contacts; `native` proves what is shown.
struct GuardedRun {
  std::string contacts;
  std::string not_run;  ///< why; empty: it ran
  std::string stopped;  ///< why before the end; empty: it came there
  std::size_t steps = 0, frames = 0;
  std::size_t cut = 0, standing = 0;  ///< steps in which something was
  std::size_t stalled = 0;  ///< frames in which a joint gave all its torque and the hand moved back or stood
  std::size_t driven_back = 0;  ///< of them, against where it was asked to go
  std::size_t merged = 0;       ///< contact points, by `exact` where it is built, of all steps as shown
  /// Of the scene's own poses: contact points at which solids touch or overlap before the first step (a box
  /// on a floor has four), and the first pair.
  std::size_t began_merged = 0;
  std::string first_merged;
  std::string judge;
  double least_separation = kInfinity;  ///< shown [m]
  double linear = 0.0;     ///< momentum of cuts that impulses and standing do not explain, the largest [N s]
  double energy = 0.0;     ///< that cuts took, sum [J]; below 0: they gave it
  double held_back = 0.0;  ///< farthest that anything was held back in a step [m]
  std::size_t slides_ended = 0;              ///< steps in which the guard's budget ended a slide
  std::optional<std::uint64_t> allocations;  ///< in frames after the first ten in which nothing was latched
  measures::StepTimes frame, step;           ///< processor time of the thread, proof and all [us]
  measures::StepTimes wall;                  ///< of frames, by the clock on the wall [us]
  std::vector<Sample> samples;
};

GuardedRun run_scene(const GuardedScene& scene, const BackendRegistry& registry, const std::string& contacts,
                     program::ProgressLine& progress);

/// Tables for a terminal, and what their columns are.
std::string terminal_text(const std::string& name, const GuardedScene& scene,
                          const std::vector<GuardedRun>& runs);
std::string legend_text();
std::string results_csv(const std::string& name, const std::vector<GuardedRun>& runs);
std::string series_csv(const GuardedRun& run);
std::string plot(const GuardedScene& scene, const std::vector<GuardedRun>& runs);

}  // namespace touchstone::guarded
