#pragma once

#include <array>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// Published swept cases with exact times, held against find_impact() over any backend.

namespace touchstone {

struct SweptCase {
  static constexpr double kNever = kInfinity;

  std::string name;
  std::array<Hexahedron, 2> solids;
  std::array<Pose, 2> X_OS;  ///< in their bodies: what turns, turns about its body's origin
  std::array<RigidPath, 2> paths;
  double duration;     ///< [s]
  double exact_time;   ///< when the closed solids first meet; kNever [s]
  double error = 0.0;  ///< of exact_time [s]
};

struct SweptAnswer {
  double gap;                           ///< the contact gap of the case [m]
  double lo;                            ///< [s]; kNever: clear
  double start_separation, separation;  ///< at the start and at lo, by `exact` [m]
  /// Of the whole path, by `exact`; only where it never meets and goes straight, where the distance is
  /// convex in time [m].
  double least_separation = kNaN;
  int queries = 0;
  bool is_sampled = false;
  /// Empty, or what is wrong: late, too far away, a stop that nothing calls for.
  std::string violation;
  std::string remark;
};

/// @param narrowphase is built over the case's solids.
SweptAnswer answer(const SweptCase& swept, Narrowphase& narrowphase);

}  // namespace touchstone
