#include <gtest/gtest.h>

#include "touchstone/tests/native/native_fixture.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

TEST(Native, EvaluateNeverAllocates) {
  Random random(21);
  const AllPairs scene = random.crowd(40);
  const auto native = make_native();
  native->build(scene.solids);
  const auto workspace = native->make_workspace();
  Answers answers;  // sized before, so that the first call counts
  answers.status.resize(scene.pairs.size());
  answers.geometry.resize(scene.pairs.size());
  answers.points.resize(kMaxManifoldPoints * scene.pairs.size());
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    const std::size_t before = allocation_count();
    evaluate(*native, scene.pairs, scene.poses, Query{kind}, *workspace, answers);
    EXPECT_EQ(allocation_count(), before) << to_string(kind);
  }
}

}  // namespace
}  // namespace touchstone
