#pragma once

#include <vector>

#include "touchstone/physics/world/islands/islands.hpp"

// Velocities after an island's impulses, and how far these are from a solution.

namespace touchstone::physics::stepping {

struct IslandResidual {
  double worst;   // the natural residual or a little more [m/s], [rad/s]
  bool is_still;  // it is no more than rounding, or almost
};

/// Owns scratch memory.
class IslandVelocities {
 public:
  void reserve(std::size_t blocks);
  /// For rows as they were gathered: what does not depend on impulses.
  void begin(const ContactRows& rows);
  /// Writes rows.u = W x + b for the island's rows by way of its units' velocities, without W: the cost is
  /// that of the rows, not of their square. @pre begin()
  IslandResidual update(const Islands& islands, const Island& island, ContactRows& rows);

 private:
  std::vector<double> residuals_, scales_;  // by block of the island
  std::vector<double> traces_;              // of W's block, by contact of the group
};

}  // namespace touchstone::physics::stepping
