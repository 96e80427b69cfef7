#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"

// Phantom contacts, as edge_face.hpp documents them.

namespace touchstone {
namespace {

using measures::PairSet;
using measures::PosedPair;

struct Phantoms {
  std::size_t hits = 0, count = 0;
  double furthest = 0;  ///< apart, over S
  double excess = 0;    ///< the most of that beyond the declared resolution and the faces' bends, over S
};

// The plane is that of three corners; the fourth of a bent face lies four times the face's bend off it.
double off_plane(const Hexahedron& solid) { return 4.0 * solid.out_of_plane(); }

Phantoms phantoms(const PairSet& set) {
  BackendRegistry registry;
  register_core(registry);
  const auto backend = registry.make_narrowphase("edge_face");
  backend->build(set.solids);
  const double resolution = backend->capabilities().resolution.relative;
  std::vector<PairStatus> status(set.pairs.size());
  backend->evaluate({.pairs = set.pairs, .poses = set.poses, .query = {}}, {.status = status},
                    *backend->make_workspace());
  Phantoms found;
  for (std::size_t i = 0; i < status.size(); ++i) {
    if (status[i] != PairStatus::overlapping) continue;
    const PosedPair posed = measures::posed_pair(set, i);
    const double separation = exact_signed_distance(posed.a, posed.b).separation;
    ++found.hits;
    found.count += separation > 0.0;
    found.furthest = std::max(found.furthest, separation / posed.scale);
    const double bends = off_plane(set.solids[set.pairs[i].a]) + off_plane(set.solids[set.pairs[i].b]);
    found.excess = std::max(found.excess, (separation - bends) / posed.scale - resolution);
  }
  return found;
}

TEST(EdgeFacePhantoms, AHitIsACommonPointToTheDeclaredResolutionAndTheBends) {
  for (const measures::PairFamily& family : measures::pair_families()) {
    const Phantoms found = phantoms(measures::make_pair_family(family.name, 51, 1500));
    std::printf("%-14.*s %zu hits, %zu phantoms, %.2g S apart at most\n",
                static_cast<int>(family.name.size()), family.name.data(), found.hits, found.count,
                found.furthest);
    EXPECT_LE(found.excess, 0.0) << family.name;
  }
}

TEST(EdgeFacePhantoms, NearlyParallelEdgesHaveSome) {
  const Phantoms found = phantoms(measures::make_pair_family("near_parallel", 51, 1500));
  EXPECT_GT(found.count, found.hits / 50);
  EXPECT_LT(found.count, found.hits / 5);
}

}  // namespace
}  // namespace touchstone
