#pragma once

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"
#include "touchstone/examples/measures/paths/path_impact.hpp"
#include "touchstone/examples/measures/paths/path_truth.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"

namespace touchstone::comparison {

/// A stop that is so far from the contact still is early, and wrong [S].
inline constexpr double kEarlyFrom = 1e-3;

/// The faults of an answer about a path.
struct PathFault {
  std::string id;
  std::string reason;  ///< missed, late, phantom, early, open, failed; empty: a cost alone
  double s = 0;        ///< where motion stops by the backend's answers; 1: nowhere
  double cost = 0;     ///< [m]: how deep the solids are there, or how far apart; at poses in between, too
  double cost_over_scale = 0;
};

/// "stops at s = 0.25 (late)", "clear to the end".
std::string stop_text(double s, const std::string& reason);

/// One backend on one set of paths.
struct PathBackendResult {
  std::string name;
  std::string sweep;             ///< of an engine's own sweep: its description
  std::string why_none;          ///< why it was not asked for times of impact; empty: it was
  std::string check = "proven";  ///< proven or sampled (MotionCheck), swept: by the engine's own sweep
  // Times of impact; missed: it goes through, late: it stops in the contact.
  std::size_t missed = 0, late = 0, phantom = 0, early = 0, open = 0, failed = 0, unsupported = 0,
              answered = 0;
  PathFault worst;                ///< the dearest of all answers, right ones among them
  std::vector<PathFault> faults;  ///< wrong and open ones, the dearest first, at most kKeptWrongCases
  // The first of the path's poses at which it answers contact, beside the exact one.
  std::size_t pose_right = 0, pose_later = 0, pose_earlier = 0, pose_open = 0;

  std::size_t wrong() const { return missed + late + phantom + early + failed; }
};

/// All backends on one set of paths.
struct PathSetResult {
  std::string name;
  std::size_t paths = 0, poses = 0;
  std::size_t meets = 0, open = 0;
  std::size_t unseen = 0;  ///< paths that meet, yet at none of their poses
  std::vector<PathBackendResult> backends;
};

/// Judgement of the classes at the poses: poses_truth is of the set's cases, `truth` of its paths.
PathSetResult begin_paths(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth,
                          std::span<const PairTruth> poses_truth);

/// One backend's results. @param overlap its answers at the poses, empty: none.
PathBackendResult judge_paths(const PairSet& set, std::size_t poses, std::span<const PathTruth> truth,
                              std::span<const PairTruth> poses_truth, const PathAnswers& answers,
                              std::span<const PairStatus> overlap, const Oracle& oracle);

}  // namespace touchstone::comparison
