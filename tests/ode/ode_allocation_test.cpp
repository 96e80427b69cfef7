#include <gtest/gtest.h>

#include "touchstone/tests/ode/heap_count.hpp"
#include "touchstone/tests/ode/ode_scenes.hpp"
#include "touchstone/tests/ode/random_scene.hpp"

namespace touchstone::ode_test {
namespace {

TEST(OdeNarrowphase, EvaluateNeverCallsTheHeapAfterTheFirstCall) {
  const PairScene scene = mixed_scene(300);
  const auto narrowphase = registry().make_narrowphase("ode");
  const std::size_t at_build = heap_calls();
  narrowphase->build(scene.solids);
  EXPECT_GT(heap_calls(), at_build);  // the counter counts
  const auto workspace = narrowphase->make_workspace();
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    Answers answers;
    const Query query{.kind = kind};
    evaluate(*narrowphase, scene.pairs, scene.poses, query, *workspace, answers);
    const std::size_t before = heap_calls();
    evaluate(*narrowphase, scene.pairs, scene.poses, query, *workspace, answers);
    EXPECT_EQ(heap_calls() - before, 0u) << to_string(kind);
  }
}

// dSAPSpace makes its arrays anew in every dSpaceCollide: 13 calls for these 450 solids in ODE 0.16.2. Ours
// are none.
TEST(OdeBroadphase, OnlyTheEngineCallsTheHeapAfterWarmUp) {
  std::mt19937_64 random(6);
  const Scene scene = random_scene(300, Vector3::Zero(), random);
  const auto broadphase = registry().make_broadphase("ode");
  broadphase->build({scene.pointers, 0.0});
  std::vector<std::uint32_t> all(300);
  for (std::uint32_t i = 0; i < 300; ++i) all[i] = i;
  std::vector<SolidPair> block(64);
  for (int i = 0; i < 2; ++i) broadphase->update(scene.poses, all);
  const std::size_t before = heap_calls();
  for (int i = 0; i < 10; ++i) broadphase->update(scene.poses, all);
  EXPECT_EQ(heap_calls() - before, 130u);
  const std::size_t before_pairs = heap_calls();
  for (PairCursor cursor; !cursor.done;) broadphase->find_pairs(cursor, block);
  EXPECT_EQ(heap_calls() - before_pairs, 0u);
}

}  // namespace
}  // namespace touchstone::ode_test
