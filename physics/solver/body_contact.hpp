#pragma once

#include <cstddef>
#include <cstdint>

/// @file
/// Contacts between bodies as convex problems take them: rows of J are a direction and the lever's product
/// with it, so that velocities, impulses and J^T G J need a third of the products of rows that are written
/// out. Contacts of the same bodies lie side by side, so that their arithmetic is done at once.

namespace touchstone::physics {

/// Contacts of one body, or of the same two; in lanes, of which the last may be empty: all 0.
struct BodyContacts {
  static constexpr std::size_t kLanes = 4, kRows = 3 * kLanes;

  /// Normals and tangents, as the first body's rows have them, by direction and component; the second's are
  /// opposed.
  double directions[3][3][kLanes] = {};
  double levers[2][3][kLanes] = {};  ///< from each body's centre to where impulses act, by component
  std::size_t first[2] = {0, 0};     ///< of each body's rates: its centre's velocity, then its turning
  std::uint32_t units[2] = {0, 0};   ///< the bodies
  int count = 0;                     ///< of them: 1 or 2
  std::size_t contacts = 0;          ///< lanes that are one
};

}  // namespace touchstone::physics
