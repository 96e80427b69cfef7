#include "touchstone/tests/proof/long_run/long_run.hpp"

#include <gtest/gtest.h>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/proof/checks/lying_narrowphase.hpp"

namespace touchstone::proof {
namespace {

std::string shown(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults)
    text += "\n" + std::to_string(fault.family) + ":" + std::to_string(fault.index) + " " + fault.what;
  return text;
}

// The slice that CI runs; another seed than the long run's, so that it adds to it.
TEST(LongRun, ASliceHasNoFault) {
  const LongRunResult result = long_run({.seed = 2, .count = 6000, .distances = 1500}, make_native);
  const FamilyTally all = result.total();
  EXPECT_GE(all.pairs, 6000u);
  EXPECT_GE(all.distances, 1500u);
  EXPECT_EQ(all.faults(), 0u) << shown(result.faults);
  EXPECT_LT(all.unsettled, 30u);
  EXPECT_GT(all.by_filter, all.pairs / 2);
}

std::unique_ptr<Narrowphase> lying(LyingNarrowphase::Lie lie) {
  return std::make_unique<LyingNarrowphase>(std::move(lie));
}

LongRunResult run_on(const LyingNarrowphase::Lie& lie) {
  return long_run({.seed = 3, .count = 300, .distances = 300, .threads = 1}, [&] { return lying(lie); });
}

TEST(LongRun, CountsEveryWrongClass) {
  const LongRunResult result = run_on([](const NarrowphaseInput&, const NarrowphaseOutput& output) {
    for (PairStatus& status : output.status)
      status = status == PairStatus::overlapping ? PairStatus::separated : PairStatus::overlapping;
  });
  const FamilyTally all = result.total();
  EXPECT_EQ(all.missed, all.touching + all.penetrating);
  EXPECT_EQ(all.phantom, all.separated);
  EXPECT_GT(all.missed, 0u);
  EXPECT_GT(all.phantom, 0u);
  EXPECT_FALSE(result.faults.empty());
}

TEST(LongRun, CountsWrongSignsAndDistances) {
  std::size_t zeros = 0;
  const FamilyTally negated = run_on([&](const NarrowphaseInput&, const NarrowphaseOutput& output) {
                                for (PairGeometry& g : output.geometry) {
                                  zeros += g.separation == 0.0 ? 1U : 0U;
                                  g.separation = -g.separation;
                                }
                              }).total();
  // A separation of 0, of pairs that touch or overlap by less than its rounding, shows no change of sign.
  EXPECT_GE(negated.wrong_sign + zeros, negated.separated + negated.penetrating);
  EXPECT_GT(negated.wrong_sign, 9 * (negated.separated + negated.penetrating) / 10);
  EXPECT_LE(negated.wrong_sign, negated.separated + negated.penetrating + negated.touching);
  EXPECT_EQ(negated.beyond_bound + negated.ulps[0] + negated.touching >= negated.pairs / 2, true);
  const FamilyTally stretched = run_on([](const NarrowphaseInput&, const NarrowphaseOutput& output) {
                                  for (PairGeometry& g : output.geometry) g.separation *= 1.0 + 1e-9;
                                }).total();
  EXPECT_EQ(stretched.wrong_sign, 0u);
  EXPECT_GT(stretched.beyond_bound, stretched.distances / 4);
}

TEST(LongRun, ThreadsDoNotShow) {
  const LongRunOptions one{.seed = 4, .count = 1500, .distances = 100, .threads = 1};
  LongRunOptions three = one;
  three.threads = 3;
  const FamilyTally p = long_run(one, make_native).total(), q = long_run(three, make_native).total();
  EXPECT_EQ(p.pairs, q.pairs);
  EXPECT_EQ(p.touching, q.touching);
  EXPECT_EQ(p.by_filter, q.by_filter);
  EXPECT_EQ(p.ulps, q.ulps);
  EXPECT_EQ(p.worst_over_S, q.worst_over_S);
}

}  // namespace
}  // namespace touchstone::proof
