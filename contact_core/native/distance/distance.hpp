#pragma once

#include "touchstone/contact_core/native/solids/posed_pair.hpp"

namespace touchstone::native {

/// About the hulls' common origin.
struct SignedDistance {
  double separation;
  Vector3 n;  ///< unit, A to B
  Vector3 p_A;
};

/// Of hulls that are certainly apart. False when further apart than `limit`. The result is accepted when |v|
/// and the projections' gap along v / |v| (an upper and a lower bound of the distance) agree to 16 u *
/// extent; when v is short against the hulls, it is first computed anew from its simplex in double-double
/// arithmetic, so that the normal does not drown in rounding. What is left (slivers, gaps of a few u) is
/// searched exhaustively. May come out <= 0 when the true distance is below rounding.
bool distance_apart(const PosedPair& pair, double limit, SignedDistance& result);

/// Of hulls that meet: the minimal translation, see best_facet_axis(). At most 0.
void penetration(const PosedPair& pair, SignedDistance& result);
/// The same where separation and n are known: finds p_A.
void penetration_along(const PosedPair& pair, SignedDistance& result);

}  // namespace touchstone::native
