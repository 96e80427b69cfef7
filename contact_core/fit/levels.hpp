#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"

namespace touchstone {

/// A coarser tree of an object, for ObjectDescription::levels.
struct CoarserLevel {
  std::shared_ptr<const HexahedronTree> tree;  ///< of the object's name
  double excess;                               ///< no point of it is farther from the solid [m]
};

/// Coarser and coarser trees of an object, one for each error. Hexahedra are merged two by two, those first
/// whose common box grows least, while no point of the box is farther from `solid` than the error; each level
/// merges those of the level before; boxes whose distance takes long to bound stay unmerged. Each hexahedron
/// lies in one of the next level, by exact predicates: worlds take them as they are.
///
/// @param solid that the tree covers, in the object's frame.
/// @param overs ascending, each positive and finite [m].
/// @throws InputError: another order, or a rounded hexahedron.
std::vector<CoarserLevel> coarser_levels(const HexahedronTree& tree, const MeshDistance& solid,
                                         std::span<const double> overs);
/// The same where the tree itself is the solid.
std::vector<CoarserLevel> coarser_levels(const HexahedronTree& tree, std::span<const double> overs);

}  // namespace touchstone
