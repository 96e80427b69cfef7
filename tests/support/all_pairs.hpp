#pragma once

#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Posed solids and all pairs of them.
struct AllPairs {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

/// `count` solids: make_solid(i), then make_pose(), for each.
template <typename MakeSolid, typename MakePose>
AllPairs all_pairs(SolidIndex count, const MakeSolid& make_solid, const MakePose& make_pose) {
  AllPairs scene;
  for (SolidIndex i = 0; i < count; ++i) {
    scene.solids.push_back(make_solid(i));
    scene.poses.push_back(make_pose());
    for (SolidIndex j = 0; j < i; ++j) scene.pairs.push_back({j, i});
  }
  return scene;
}

}  // namespace touchstone
