#pragma once

#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/world/objects/object_levels.hpp"

namespace touchstone {

/// One of the two in a search: an object with levels, or one hexahedron. Borrowed.
struct SearchedBody {
  const ObjectLevels* levels;  ///< null: one hexahedron
  const Hexahedron* solids;    ///< the object's, by ObjectLevels::Node::solid; or the one
  const Pose* X_OS;            ///< of these in the object; null: of the one, which is at X_W
  SolidIndex first;            ///< index of the first of these
  Pose X_W;                    ///< of the object; or of the one hexahedron
};

/// Appends to `out` the pairs of hexahedra, one of each, a < b and in no order, that may be within `reach` of
/// each other where the two stand: all that are, and few others. Bounds that are further apart along an axis,
/// the line of their centres or a face's normal, take all below them out. Allocates only where `out` has no
/// room.
void find_pairs_within(double reach, const SearchedBody& a, const SearchedBody& b,
                       std::vector<SolidPair>& out);

}  // namespace touchstone
