#pragma once

#include <optional>

#include "touchstone/contact_core/narrowphase/pair_class.hpp"
#include "touchstone/tests/proof/pairs/posed_solids.hpp"

// The class of a pair by a second method, which shares no code with contact_core's predicates nor with the
// `exact` adapter, and no idea of a hull's faces and edges either: every direction that could be a facet
// normal of the difference of two sets of eight points is tried, the normals of all triples of points of one
// set and the cross products of all pairs of one with all pairs of the other. Each direction gets the sign of
// its gap from an interval filter; what the filter leaves is decided in scaled integers (GMP).

namespace touchstone::proof {

struct SettledClass {
  /// Empty: contact of two sets whose difference has no volume (all sixteen points' directions in one plane),
  /// which these directions do not decide.
  std::optional<PairClass> pair_class;
  int directions_in_integers = 0;  ///< 0: the filter alone settled the pair
};

SettledClass settle_class(const PosedSolids& solids);

/// Without the filter: every direction in integers, as the filter's own check.
SettledClass settle_class_in_integers(const PosedSolids& solids);

}  // namespace touchstone::proof
