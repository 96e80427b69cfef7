#include "touchstone/contact_core/broadphase/first_contact.hpp"

#include <gtest/gtest.h>

#include "touchstone/tests/broadphase/random_scene.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using namespace broadphase_tests;

struct Check {
  std::unique_ptr<Narrowphase> narrowphase;
  std::unique_ptr<Narrowphase::Workspace> workspace;
  Pairs block = Pairs(4096);
  std::vector<PairStatus> status = std::vector<PairStatus>(4096);

  explicit Check(const Scene& scene) {
    BackendRegistry registry;
    register_core(registry);
    narrowphase = registry.make_narrowphase("native");
    narrowphase->build(scene.solids);
    workspace = narrowphase->make_workspace();
  }

  std::optional<FirstContact> first(Broadphase& broadphase, const Scene& scene, std::size_t block_size) {
    return find_first_contact(broadphase, *narrowphase, scene.poses, *workspace,
                              std::span(block).first(block_size), std::span(status).first(block_size));
  }

  // From the full list.
  std::optional<SolidPair> lowest(const Pairs& pairs, const Scene& scene) const {
    std::vector<PairStatus> all(pairs.size());
    narrowphase->evaluate({.pairs = pairs, .poses = scene.poses, .query = {}}, {.status = all}, *workspace);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (all[i] == PairStatus::overlapping) return pairs[i];
    return std::nullopt;
  }
};

class FirstContactTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Core, FirstContactTest, testing::Values("brute_force", "native"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(FirstContactTest, IsTheLowestOfTheFullListForAnyBlockSize) {
  int contacts = 0, late = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const double extent = seed % 2 == 0 ? 60 : 400;  // from many contacts to few, high up or none
    const Scene scene = random_scene(700, extent, 0, 50 + seed);
    Check check(scene);
    const auto expected = check.lowest(sweep(*make("brute_force", scene, 0.0), 4096), scene);
    contacts += expected ? 1 : 0;
    late += expected && expected->a > 100 ? 1 : 0;
    for (std::size_t block_size : {1, 5, 64, 4096}) {
      const auto broadphase = make(GetParam(), scene, 0.0);
      const auto first = check.first(*broadphase, scene, block_size);
      ASSERT_EQ(first.has_value(), expected.has_value()) << seed;
      if (!first) continue;
      EXPECT_EQ(first->pair, *expected) << seed << ", blocks of " << block_size;
      EXPECT_EQ(first->status, PairStatus::overlapping);
    }
  }
  EXPECT_GT(contacts, 6);
  EXPECT_GT(late, 0);
}

TEST_P(FirstContactTest, LeavesTheFullListAsItWas) {
  Scene scene = random_scene(600, 60, 0, 70);
  Check check(scene);
  const auto broadphase = make(GetParam(), scene, 0.0);
  ASSERT_TRUE(check.first(*broadphase, scene, 64));
  const std::size_t before = allocation_count();
  ASSERT_TRUE(check.first(*broadphase, scene, 64));
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(sweep(*broadphase, 64), sweep(*make("brute_force", scene, 0.0), 64));
}

}  // namespace
}  // namespace touchstone
