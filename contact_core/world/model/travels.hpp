#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// How far solids have gone since counting began, as sums of bounds: a pair that was d apart when its sums
/// were t cannot be nearer than c before they are t + d - c. Motion within a mechanism, of links relative to
/// each other, has a sum for each pair of its links.
struct Travels {
  GrowingList<double> of_solid;      ///< [m]
  std::vector<double> of_link_pair;  ///< by pair of links [m]
  GrowingList<double> solid_limit;   ///< of_solid up to which the watched pairs are all that may come near
  GrowingList<double> last_solid;    ///< of the path that was laid last [m]; 0: at rest
  std::vector<double> last_link_pair;
  GrowingList<double> planned_solid;  ///< of a path that a slide may take [m]
  std::vector<double> planned_link_pair;
  std::uint64_t clearings = 0;  ///< of the two: what movers know of their plans there ends with each
  // The same of objects that have levels, by slot: no point of one goes further. Of their solids the sums
  // above count while these are open.
  GrowingList<double> of_object, last_object, object_limit, needed_object;  ///< [m]
  GrowingList<double> needed;              ///< how far on slides of rigid bodies ask what is watched [m]
  GrowingList<WorldVertices> vertices;     ///< as it stands, once asked for
  GrowingList<std::uint8_t> has_vertices;  ///< by solid
  std::vector<SolidIndex> unplaced;        ///< within place_vertices()

  /// Sums beyond this mean nothing: squares of lengths may have overflowed.
  static constexpr double kMost = 0x1p500;

  /// Sums round up: what is lost in one addition is less than the last term.
  static double sum(double travelled, double more) {
    return travelled + more * (1.0 + 0x1p-20) + travelled * 0x1p-50;
  }
};

}  // namespace touchstone
