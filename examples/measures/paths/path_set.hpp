#pragma once

#include <array>

#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/examples/measures/pairs/pair_set.hpp"

/// @file
/// Paths of two solids as sets of pairs: `poses` consecutive cases are one path, at s = 0, 1 / (poses - 1)
/// and so on to 1, with the ids "id@0", "id@1" ... So engines are asked about them, and judged, as about any
/// pairs. Between its poses a path follows from its ends: each solid's origin moves straight and it turns at
/// a constant rate about a fixed axis, the shorter way (RigidPath::between).

namespace touchstone::measures {

/// Two solids on their paths, s from 0 to 1.
struct SolidPaths {
  std::string id;
  std::array<Hexahedron, 2> solids;
  std::array<RigidPath, 2> ways;
  double scale = 0;  ///< S: the larger of sizes and coordinates, at the path's ends [m]
};

/// Adds a path to the set, each case with solids of its own.
void append_path(PairSet& set, const std::string& id, const std::array<Hexahedron, 2>& solids,
                 const std::array<RigidPath, 2>& ways, std::size_t poses);

/// Path `index` of such a set, from the first and the last of its cases.
SolidPaths paths_of(const PairSet& set, std::size_t poses, std::size_t index);

}  // namespace touchstone::measures
