#include "touchstone/examples/measures/paths/path_set.hpp"

#include <algorithm>

namespace touchstone::measures {

void append_path(PairSet& set, const std::string& id, const std::array<Hexahedron, 2>& solids,
                 const std::array<RigidPath, 2>& ways, std::size_t poses) {
  for (std::size_t k = 0; k < poses; ++k) {
    const double s = static_cast<double>(k) / static_cast<double>(poses - 1);
    const auto first = static_cast<SolidIndex>(set.solids.size());
    set.solids.insert(set.solids.end(), solids.begin(), solids.end());
    for (const RigidPath& way : ways) set.poses.push_back(way.pose_at(s));
    set.pairs.push_back({first, first + 1});
    set.ids.push_back(id + "@" + std::to_string(k));
  }
}

SolidPaths paths_of(const PairSet& set, std::size_t poses, std::size_t index) {
  const std::size_t first = index * poses, last = first + poses - 1;
  const SolidPair from = set.pairs[first], to = set.pairs[last];
  const std::string id = case_id(set, first);
  return {id.substr(0, id.rfind('@')),
          {set.solids[from.a], set.solids[from.b]},
          {RigidPath::between(set.poses[from.a], set.poses[to.a]),
           RigidPath::between(set.poses[from.b], set.poses[to.b])},
          std::max(posed_pair(set, first).scale, posed_pair(set, last).scale)};
}

}  // namespace touchstone::measures
