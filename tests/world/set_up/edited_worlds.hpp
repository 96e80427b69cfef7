#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

// Random worlds that set-up changes while frames run, each registered in several orders: nothing that is
// executed may show in which.

namespace touchstone {

/// Where a world first differs from the same one in another order.
struct OrderFinding {
  std::uint64_t seed;
  int frame;
  std::string what;  ///< whose pose or joint values, or `events`
  double by;         ///< largest difference of a pose's position [m]; 0: of something else
};

struct OrderFigures {
  std::uint64_t worlds = 0, frames = 0;
  std::uint64_t slid = 0;       ///< frames
  std::uint64_t arms_slid = 0;  ///< of these, an arm was stopped
  std::uint64_t edits = 0;
  std::uint64_t overlaps = 0;  ///< pairs that set-up left in overlap
  std::vector<OrderFinding> findings;
};

/// Flies `worlds` worlds, of the seeds from `seed` on. In each an arm or two, and solids that stand, are
/// commanded or go along, among them some in overlap; links and bodies carry others. Every other frame some
/// are added, removed, latched, let go, exempted, switched or ruled otherwise. Five times the same: as drawn;
/// with all that is registered, edited and commanded in two other orders; as drawn on two threads; and as
/// drawn where every object has levels.
OrderFigures fly_edited_worlds(std::uint64_t seed, std::uint64_t worlds);

void print(std::ostream& out, const OrderFigures& figures);

}  // namespace touchstone
