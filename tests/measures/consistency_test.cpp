#include "touchstone/examples/measures/runs/consistency.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <string_view>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

namespace touchstone::measures {
namespace {

enum class Fault { none, keeps_its_normal, counts_its_calls, sees_the_world };

Capabilities distances() {
  Capabilities capabilities;
  capabilities.distance = true;
  return capabilities;
}

// The distance of the centres, with a fault of choice.
class Faulty final : public testing::PairByPair {
 public:
  explicit Faulty(Fault fault) : PairByPair("faulty", distances()), fault_(fault) {}

 private:
  void answer(const NarrowphaseInput& input, std::size_t i, const NarrowphaseOutput& output) const override {
    const auto [a, b] = input.pairs[i];
    const Vector3 apart = input.poses[b].p - input.poses[a].p;
    PairGeometry& geometry = output.geometry[i];
    geometry.separation = norm(apart);
    if (fault_ == Fault::counts_its_calls) geometry.separation += 1e-6 * static_cast<double>(++calls_);
    if (fault_ == Fault::sees_the_world) geometry.separation += 1e-3 * std::abs(input.poses[a].p.x());
    geometry.n_AB_W = fault_ == Fault::keeps_its_normal ? Vector3::UnitX() : Vector3(apart / norm(apart));
    output.status[i] = PairStatus::separated;
  }

  Fault fault_;
  mutable std::atomic<int> calls_{0};
};

Consistency of(Fault fault) {
  return check_consistency(Faulty(fault), make_pair_family("random", 1, 200), 2);
}

TEST(Consistency, AskedInAnyWayTheSameIsSaid) {
  const Consistency found = of(Fault::none);
  for (const Change& change : {found.swapped, found.repeated, found.threads}) {
    EXPECT_EQ(change.cases, 200u);
    EXPECT_EQ(change.classes, 0u);
    EXPECT_EQ(change.bits, 0u);
    EXPECT_EQ(change.worst, 0.0);
  }
  EXPECT_LT(found.moved.worst, 1e-15);
}

TEST(Consistency, EveryFaultShowsWhereItBelongs) {
  EXPECT_EQ(of(Fault::keeps_its_normal).swapped.bits, 200u);
  EXPECT_EQ(of(Fault::keeps_its_normal).repeated.bits, 0u);
  EXPECT_EQ(of(Fault::counts_its_calls).repeated.bits, 200u);
  EXPECT_GT(of(Fault::counts_its_calls).threads.bits, 0u);
  EXPECT_GT(of(Fault::sees_the_world).moved.worst, 1e-5);
  EXPECT_EQ(of(Fault::sees_the_world).repeated.bits, 0u);
}

// Overlaps, or separations too, by the sign of a centre distance that rounding flips: it contradicts itself
// whenever the set is moved.
class Fickle final : public testing::PairByPair {
 public:
  explicit Fickle(const Capabilities& capabilities) : PairByPair("fickle", capabilities) {}

 private:
  void answer(const NarrowphaseInput& input, std::size_t i, const NarrowphaseOutput& output) const override {
    const auto [a, b] = input.pairs[i];
    const bool moved = input.poses[a].R(0, 0) != 1;
    output.status[i] = moved ? PairStatus::separated : PairStatus::overlapping;
    if (capabilities().distance && !output.geometry.empty()) output.geometry[i].separation = 0.0;
  }
};

TEST(Consistency, TouchingIsLeftOutByTheExactSeparationWhateverIsReported) {
  PairSet set = testing::cubes({0.0, 0.0, 0.25});
  Fickle overlaps{Capabilities{}}, separations{distances()};
  for (const Narrowphase* each :
       {static_cast<Narrowphase*>(&overlaps), static_cast<Narrowphase*>(&separations)}) {
    set.exact_separations.clear();
    EXPECT_EQ(check_consistency(*each, set, 2).moved.classes, 3u);
    EXPECT_EQ(check_consistency(*each, set, 2).moved.left_out, 0u);
    set.exact_separations = {0.0, 0.0, 0.25};
    EXPECT_EQ(check_consistency(*each, set, 2).moved.classes, 1u);
    EXPECT_EQ(check_consistency(*each, set, 2).moved.left_out, 2u);
  }
}

TEST(Consistency, ASeparationThatIsNeverGivenHasNoChange) {
  const PairSet set = testing::cubes({0.0, 0.25});
  const Consistency found = check_consistency(Fickle(Capabilities{}), set, 2);
  EXPECT_TRUE(std::isnan(found.repeated.worst));
  EXPECT_EQ(check_consistency(Fickle(distances()), set, 2).repeated.worst, 0.0);
  Change sum = found.repeated;
  sum += check_consistency(Fickle(distances()), set, 2).repeated;
  EXPECT_EQ(sum.worst, 0.0);
  EXPECT_EQ(sum.cases, 4u);
}

TEST(Consistency, NativeSaysTheSameInEveryWay) {
  const auto oracle = make_exact_oracle();
  BackendRegistry registry;
  register_core(registry);
  const auto native = registry.make_narrowphase("native");
  for (const char* family : {"random", "touching", "near_parallel"}) {
    PairSet set = make_pair_family(family, 5, 300);
    if (oracle) {
      for (const PairTruth& truth : compute_truth(set, *oracle, 2))
        set.exact_separations.push_back(truth.separation);
    }
    native->build(set.solids);
    const Consistency found = check_consistency(*native, set, 2);
    for (const Change& change : {found.swapped, found.repeated, found.threads}) {
      EXPECT_EQ(change.bits, 0u) << family;
      EXPECT_EQ(change.classes, 0u) << family;
    }
    if (oracle || family != std::string_view("touching")) {
      EXPECT_EQ(found.moved.classes, 0u) << family;
    }
  }
}

}  // namespace
}  // namespace touchstone::measures
