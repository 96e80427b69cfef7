#include <gtest/gtest.h>

#include "native_fixture.hpp"
#include "tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

TEST(Native, EvaluateNeverAllocates) {
  Random random(21);
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  for (SolidIndex i = 0; i < 40; ++i) {
    solids.push_back(random.any());
    poses.push_back(random.pose(1.0));
    for (SolidIndex j = 0; j < i; ++j) pairs.push_back({j, i});
  }
  const auto native = make_native();
  native->build(solids);
  const auto workspace = native->make_workspace();
  std::vector<PairStatus> status(pairs.size());
  std::vector<PairGeometry> geometry(pairs.size());
  std::vector<ContactPoint> points(8 * pairs.size());
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    const std::size_t before = allocation_count();
    native->evaluate({pairs, poses, Query{kind}}, {status, geometry, points}, *workspace);
    EXPECT_EQ(allocation_count(), before) << to_string(kind);
  }
}

}  // namespace
}  // namespace touchstone
