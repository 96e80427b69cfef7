#pragma once

#include <cstdint>
#include <string_view>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// The time at which two moving solids meet, by conservative advancement (Mirtich 1996) with the motion
/// projected on the separating axis (Zhang, Lee, Kim 2006). At s the pair's separation and normal n are
/// queried. Along the fixed n a vertex's path is enclosed by its value, its slope and a bound on its
/// curvature. So the distance of the projections, a lower bound of the separation, is known to stay above a
/// threshold up to some s', where the pair is queried again. Motion along a face takes one step, however
/// close.

namespace touchstone {

/// One solid in motion.
struct MovingSolid {
  const Hexahedron* solid;
  Pose X_OS;  ///< of the solid in its body
  const MotionPath* path;
  std::uint32_t body = 0;
  double stop = 1.0;  ///< the body goes no further than this s and rests there
  /// No point of the solid goes faster than this anywhere on the path [m per unit of s].
  double travel = kInfinity;
  PathViews* views = nullptr;  ///< of a mechanism's path; null: none
  /// Optional: pose and vertices at s = 0, bit-identical to those from path and X_OS. Set both or neither.
  const Pose* X_WS_at_start = nullptr;
  const WorldVertices* vertices_at_start = nullptr;

  Pose pose_at(double s) const noexcept;
};

/// The contact gap: where motion stops. All [m].
struct GapRule {
  double gap;  ///< g: a pair stops with separation in [g/2, g]; > 0

  /// The least separation allowed to a pair that starts a frame with separation `start`: 3 g/4 where start >
  /// g; else the smaller of g/2 and start - r, so that rounding does not stop motion along a contact. r is
  /// the rounding of a separation, 32 u * `scale`; from g/2 down to g/4 it falls to 0, and stays 0 down to 0.
  /// @param scale largest |world coordinate| or size of the pair [m].
  double threshold(double start, double scale) const;
};

/// The strength of the answer "clear": see Narrowphase's Capabilities.
enum class MotionCheck : std::uint8_t {
  proven,   ///< the whole path, by the separations, as far as these are right
  sampled,  ///< poses on the path, judged by a backend without separations; nothing is proven between them
};
/// The enumerator's name.
std::string_view to_string(MotionCheck check);

/// How find_impact() ended.
enum class ImpactStatus : std::uint8_t {
  clear,            ///< the whole path
  blocked,          ///< at lo
  iteration_limit,  ///< stopped early at lo, which is clear; nothing is known beyond
  failed,           ///< the backend gave no answer: at lo, or, where it judges poses, soon after lo
};

/// When a pair stops: a bracket [lo, hi] in the path's s, 0 to 1. Separations in metres.
struct Impact {
  ImpactStatus status = ImpactStatus::clear;
  MotionCheck check = MotionCheck::proven;
  double lo = 1.0;          ///< the path is clear on [0, lo]: never late; sampled: the last pose judged clear
  double hi = 1.0;          ///< beyond this s the pair is below the threshold, as far as is known; lo <= hi
  bool is_far = false;      ///< from the last query on it stays further away than asked about
  PairGeometry geometry{};  ///< at lo; where is_far, or not asked at the end, at the last query
  double start_separation = 0;          ///< at s = 0
  bool starts_overlapping = false;      ///< at s = 0, by the backend's status
  double least_separation = kInfinity;  ///< queried on [0, lo]
  int queries = 0;
};

/// Asks one narrowphase about two solids at trial poses. Holds scratch; one a thread.
class SeparationQuery {
 public:
  virtual ~SeparationQuery() = default;
  /// Signed distance, normal and witness points at these poses, as a distance query gives them.
  virtual PairStatus separation(const Pose& X_WA, const Pose& X_WB, PairGeometry& out) noexcept = 0;
  /// True: separations only set the steps; verdict() decides about poses, and answers are `sampled`.
  virtual bool judges_poses() const noexcept { return false; }
  /// Whether the two overlap at these poses.
  virtual PairStatus verdict(const Pose& X_WA, const Pose& X_WB) noexcept {
    PairGeometry unused{};
    return separation(X_WA, X_WB, unused);
  }
};

/// Most queries of one pair on one path: find_impact() then stops early: `iteration_limit`.
inline constexpr int kImpactIterations = 256;

/// A query that judges poses only is passed on to find_sampled_impact() (sampled_impact.hpp). A pair that
/// starts at or below the gap, or overlapping, is stopped only where it would fall below rule.threshold(): it
/// is free to move away and along, and no depth grows.
/// @param interest a pair that is sure to stay further apart than this to the end is not queried there [m].
/// @param until the search stops beyond this s: the result is then `clear`, with lo past it. Ignored where
/// the query judges poses.
/// @param ask_at_end false: a path that is clear to the end is not queried there, and its geometry is that of
/// the query before.
/// @pre rule.gap > 0.
Impact find_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query,
                   double interest = kInfinity, double until = 1.0, bool ask_at_end = true) noexcept;

}  // namespace touchstone
