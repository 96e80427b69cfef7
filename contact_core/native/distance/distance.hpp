#pragma once

#include "touchstone/contact_core/native/solids/posed_pair.hpp"

namespace touchstone::native {

/// About the hulls' common origin.
struct SignedDistance {
  double separation;
  Vector3 n;  ///< unit, A to B
  Vector3 p_A;
};

/// Distance of certainly separated hulls; false when it is above `limit`. The result is accepted when |v|
/// and the projections' gap along v / |v| (an upper and a lower bound of the distance) agree to 16 u *
/// extent; when v is short against the hulls, it is first recomputed from its simplex in double-double
/// arithmetic, so that the normal does not drown in rounding. The rest (slivers, gaps of a few u) is
/// searched exhaustively. May come out <= 0 when the true distance is below rounding.
bool separated_distance(const PosedPair& pair, double limit, SignedDistance& result);

/// Penetration of hulls that meet: the minimal translation, see best_facet_axis(). At most 0.
void penetration(const PosedPair& pair, SignedDistance& result);
/// Finds p_A where separation and n are known.
void penetration_along(const PosedPair& pair, SignedDistance& result);

}  // namespace touchstone::native
