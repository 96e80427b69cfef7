#include "touchstone/examples/measures/pairs/pair_set.hpp"

#include <algorithm>

namespace touchstone::measures {

std::string case_id(const PairSet& set, std::size_t index) {
  return set.ids.empty() ? set.name + ":" + std::to_string(index) : set.ids[index];
}

PosedPair posed_pair(const PairSet& set, std::size_t index) {
  const SolidPair pair = set.pairs[index % set.pairs.size()];
  const auto poses = set.frame_poses(index / set.pairs.size());
  PosedPair posed;
  world_vertices(set.solids[pair.a], poses[pair.a], posed.a);
  world_vertices(set.solids[pair.b], poses[pair.b], posed.b);
  posed.size = std::max(set.solids[pair.a].size(), set.solids[pair.b].size());
  posed.scale = std::max({posed.size, largest_coordinate(posed.a), largest_coordinate(posed.b)});
  return posed;
}

}  // namespace touchstone::measures
