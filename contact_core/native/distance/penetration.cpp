#include <algorithm>

#include "touchstone/contact_core/native/distance/facet_axes.hpp"
#include "touchstone/contact_core/native/distance/witness.hpp"

namespace touchstone::native {
namespace {

/// A candidate axis that is no facet normal can come within rounding of the best (two facets at a small
/// angle, or a small depth under a corner); its witness points are then off by up to sqrt(2 u * depth *
/// extent). The facet's own are not.
void settle_near_ties(const PosedPair& pair, SignedDistance& result) {
  Witness best = witness_along(pair, result.separation, result.n);
  if (best.error > kWitness * kRoundoff * pair.hulls.extent) {
    NearTies ties;
    find_near_ties(pair.hulls, *pair.a, pair.R_WA, *pair.b, pair.R_WB, result.separation, ties);
    for (int i = 0; i < ties.count; ++i) {
      const double separation = std::min(ties.axes[i].separation, 0.0);
      const Witness other = witness_along(pair, separation, ties.axes[i].n);
      if (!(other.error < best.error)) continue;
      best = other;
      result.separation = separation, result.n = ties.axes[i].n;
    }
  }
  result.p_A = best.p_A;
}

}  // namespace

void penetration(const PosedPair& pair, SignedDistance& result) {
  const SeparationAxis axis = best_facet_axis(pair.hulls, *pair.a, pair.R_WA, *pair.b, pair.R_WB);
  result = {std::min(axis.separation, 0.0), axis.n, Vector3::Zero()};
  settle_near_ties(pair, result);
}

void penetration_along(const PosedPair& pair, SignedDistance& result) { settle_near_ties(pair, result); }

}  // namespace touchstone::native
