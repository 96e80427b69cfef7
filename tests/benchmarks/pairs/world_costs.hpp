#pragma once

#include <string>
#include <vector>

namespace touchstone {

/// A figure of many boxes, and what is asked of it.
struct WorldCost {
  std::string work;
  double figure;
  double asked;
  const char* unit;
  std::string reason;  ///< where it is missed
};

/// Frames, builds, changes and memory of worlds of boxes, on one thread, by its processor time: the least of
/// several. Takes about a minute.
std::vector<WorldCost> measure_worlds();

}  // namespace touchstone
