#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "native_fixture.hpp"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

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
    const long before = allocations;
    native->evaluate({pairs, poses, Query{kind}}, {status, geometry, points}, *workspace);
    EXPECT_EQ(allocations, before) << to_string(kind);
  }
}

}  // namespace
}  // namespace touchstone
