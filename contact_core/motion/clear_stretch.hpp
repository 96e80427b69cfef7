#pragma once

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/impact.hpp"

// How far two moving solids go on before they could come nearer than a threshold: the step of conservative
// advancement, shared by find_impact() and find_sampled_impact().

namespace touchstone {

/// A pair in contact whose next step clears less than this share of what is left could not finish within
/// kImpactIterations: it is blocked.
inline constexpr double kStalled = 1.0 / kImpactIterations;
/// Rounding of a separation and of projections, per metre of the largest coordinate (native's declared
/// resolution): a motion along a face must not be stopped by it.
inline constexpr double kSeparationRounding = 32 * kUnitRoundoff;

struct Stretch {
  double length;
  bool at_end;
  double least_at_end;  ///< the projections are at least this far apart there; only if at_end
};

/// The first t at which c + b t - q t^2 / 2 falls below 0; c is taken as at least 0.
inline double first_root(double c, double b, double q) {
  if (c < 0.0) c = 0.0;
  if (q <= 0.0) return b < 0.0 ? c / -b : kInfinity;
  const double root = std::sqrt(b * b + 2.0 * q * c);
  return b < 0.0 ? 2.0 * c / (root - b) : (root + b) / q;
}

/// A solid at one s of its path.
struct PlacedSolid {
  const MovingSolid* moving = nullptr;
  bool at_rest = true;
  double s = 0.0;
  BodyState state;  ///< rates are 0 at rest
  Pose X_WS;
  WorldVertices vertices;
};

PlacedSolid place(const MovingSolid& moving, double s);

/// Says whether two solids overlap further on along their paths, where no plane parts them.
class OverlapAhead {
 public:
  virtual ~OverlapAhead() = default;
  /// At s of both paths. False: not known to.
  virtual bool overlaps_at(double s) noexcept = 0;
};

/// Returns a stretch, `longest` at most, on which the solids are sure to stay apart by `threshold`: by the
/// plane of the closest points, or, in contact and where that plane clears little, by the best of all known
/// planes; these are not tried where the two overlap before any of them would clear kStalled of `longest`.
/// @param queries made so far on this path. @param ahead null: all planes are tried.
/// @pre both are placed at one s, where `geometry` is theirs; both paths are smooth for `longest` (see
/// next_break()).
Stretch find_clear_stretch(const PlacedSolid& a, const PlacedSolid& b, const PairGeometry& geometry,
                           const GapRule& rule, double threshold, double longest, int queries,
                           OverlapAhead* ahead = nullptr);

/// The next place on its path at which a moving pair is looked at.
struct PathStep {
  double next;              ///< clear up to there; where a solid comes to rest, or the end, at the latest
  bool at_end = false;      ///< that is s = 1
  bool is_far = false;      ///< and on all of it the two stay further apart than `interest`
  bool is_stalled = false;  ///< in contact, and it clears so little that the path could not be finished
};
/// @pre as find_clear_stretch(), at on_a.s.
PathStep next_step(const PlacedSolid& on_a, const PlacedSolid& on_b, const PairGeometry& geometry,
                   const GapRule& rule, double threshold, double interest, int queries,
                   OverlapAhead* ahead = nullptr);

/// True where the two are sure to stay further apart than `threshold` along n on the whole of their paths.
/// @param n_AB_W unit. @pre both paths are smooth: neither rests before its end.
bool stays_apart_along(const MovingSolid& a, const MovingSolid& b, const Vector3& n_AB_W, double threshold);

bool is_at_rest(const MovingSolid& moving, double s);

/// Bits of a solid's distinct vertices: without those that coincide with an earlier one. A capsule has two, a
/// solid without a radius eight.
unsigned distinct_vertices(const Hexahedron& solid, const WorldVertices& vertices);

/// The next s at which a solid comes to rest, or 1: between such points both paths are smooth.
double next_break(const MovingSolid& a, const MovingSolid& b, double s);

/// A scale of the pair, at least the S of error measures.
double scale_of(const PlacedSolid& a, const PlacedSolid& b);

/// The largest speed of any point of either solid relative to the other solid [m per unit of s].
double relative_speed(const PlacedSolid& a, const PlacedSolid& b);

/// True where the status carries a separation.
bool has_geometry(PairStatus status);

}  // namespace touchstone
