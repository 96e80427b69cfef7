#pragma once

#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// A pair of a mechanism's own hexahedra that is checked and should not be in contact, but is.
struct ReferenceOverlap {
  SolidPair solids;   ///< indices in Mechanism::solids()
  PairStatus status;  ///< `overlapping`, or what else is not `separated`
  double separation;  ///< [m]; NaN where the narrowphase gives none
};

/// Returns every pair that is not exempt and that `narrowphase` does not find separated in the reference
/// pose: a modelling error, or an exemption that was left out. None is dropped; pairs to ignore have to be
/// listed in MechanismDescription::exempt_pairs. Cold path: builds `narrowphase` anew over the mechanism's
/// solids.
std::vector<ReferenceOverlap> find_reference_overlaps(const Mechanism& mechanism, Narrowphase& narrowphase);

/// One line: mechanism, both hexahedra, status and depth.
std::string to_string(const ReferenceOverlap& overlap, const Mechanism& mechanism);

}  // namespace touchstone
