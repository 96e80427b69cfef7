#include "touchstone/contact_core/motion/sampled_impact.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/at.hpp"

namespace touchstone {
namespace {

constexpr double kGap = 1e-9;

/// Native's separations under verdicts of any kind, of the true separation.
class JudgedQuery final : public SeparationQuery {
 public:
  JudgedQuery(std::span<const Hexahedron> solids, std::function<PairStatus(double)> verdict)
      : verdict_(std::move(verdict)) {
    native_->build(solids);
  }
  PairStatus separation(const Pose& X_WA, const Pose& X_WB, PairGeometry& out) noexcept override {
    return query_.separation(X_WA, X_WB, out);
  }
  bool judges_poses() const noexcept override { return true; }
  PairStatus verdict(const Pose& X_WA, const Pose& X_WB) noexcept override {
    PairGeometry geometry{};
    query_.separation(X_WA, X_WB, geometry);
    return verdict_(geometry.separation);
  }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
  NarrowphaseQuery query_{*native_, 2};
  std::function<PairStatus(double)> verdict_;
};

PairStatus right(double separation) {
  return separation > 0.0 ? PairStatus::separated : PairStatus::overlapping;
}

struct Plates {
  std::array<Hexahedron, 2> solids{Hexahedron::from_size({1, 1, 0.01}), Hexahedron::from_size({1, 1, 0.01})};

  Impact find(const Pose& start, const Vector3& by, const std::function<PairStatus(double)>& verdict,
              const Vector3& turn = Vector3::Zero()) {
    JudgedQuery query(solids, verdict);
    const RigidPath a, b = RigidPath::by(start, by, turn);
    return find_impact({&solids[0], {}, &a}, {&solids[1], {}, &b}, {kGap}, query);
  }
};

TEST(SampledImpact, ARightVerdictStopsWhereTheSeparationsDo) {
  Plates plates;
  for (const Vector3& by : {Vector3(0, 0, -0.037), Vector3(0.3, 0.1, -0.037), Vector3(0.9, 0, -0.0050001)}) {
    const Impact impact = plates.find(at(0, 0, 0.015), by, right);
    EXPECT_EQ(impact.check, MotionCheck::sampled);
    EXPECT_EQ(impact.status, ImpactStatus::blocked);
    EXPECT_GE(impact.geometry.separation, 0.5 * kGap);
    EXPECT_LE(impact.geometry.separation, kGap);
    EXPECT_LE(impact.queries, 40);
  }
}

TEST(SampledImpact, ABlindVerdictLetsThrough) {
  Plates plates;
  for (const Vector3& turn : {Vector3(0, 0, 0), Vector3(0.7, 0.2, 3.0)}) {
    const Impact impact = plates.find(
        at(0, 0, 0.015), {0.1, 0, -0.037}, [](double) { return PairStatus::separated; }, turn);
    EXPECT_EQ(impact.status, ImpactStatus::clear);
    EXPECT_EQ(impact.lo, 1.0);
    EXPECT_LT(impact.queries, kImpactIterations);
    EXPECT_LT(impact.least_separation, 0.0);
  }
}

TEST(SampledImpact, AnEarlyVerdictIsBracketedToTheGap) {
  Plates plates;
  const Impact impact = plates.find(at(0, 0, 0.015), {0, 0, -0.037}, [](double separation) {
    return separation > 1e-3 ? PairStatus::separated : PairStatus::undecided;
  });
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_GT(impact.geometry.separation, 1e-3);
  EXPECT_LE(impact.geometry.separation, 1e-3 + kGap);
}

TEST(SampledImpact, ALateVerdictStopsAtTheLastPoseCalledClear) {
  Plates plates;
  const Impact impact = plates.find(at(0, 0, 0.015), {0, 0, -0.0051}, [](double separation) {
    return separation > -1e-6 ? PairStatus::separated : PairStatus::overlapping;
  });
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_GT(impact.geometry.separation, -1e-6);
  EXPECT_LE(impact.geometry.separation, -1e-6 + kGap);
}

TEST(SampledImpact, NoVerdictStopsWithinTheGap) {
  Plates plates;
  for (const PairStatus none : {PairStatus::failed, PairStatus::unsupported}) {
    const Impact impact = plates.find(at(0, 0, 0.015), {0, 0, -0.037}, [&](double separation) {
      return separation > 2e-3 ? PairStatus::separated : none;
    });
    EXPECT_EQ(impact.status, ImpactStatus::failed);
    EXPECT_GT(impact.geometry.separation, 2e-3);
    EXPECT_LE(impact.geometry.separation, 2e-3 + kGap);
  }
}

TEST(SampledImpact, WhatStartsInContactComesNoNearer) {
  Plates plates;
  const auto undecided_within = [](double separation) {
    return separation > 1e-3 ? PairStatus::separated : PairStatus::undecided;
  };
  for (const double start : {0.5e-3, 0.75e-9, -1e-3}) {
    const Pose X = at(0, 0, 0.01 + start);
    const Impact nearer = plates.find(X, {0.1, 0, -0.002}, undecided_within);
    EXPECT_EQ(nearer.status, ImpactStatus::blocked) << start;
    EXPECT_LT(nearer.lo, 1e-3) << start;
    EXPECT_GE(nearer.geometry.separation, std::min(start, 0.5 * kGap) - 1e-13) << start;
    const Impact along = plates.find(X, {0.1, 0.05, 0}, undecided_within);
    EXPECT_EQ(along.status, ImpactStatus::clear) << start;
    const Impact away = plates.find(X, {0, 0, 0.004}, undecided_within);
    EXPECT_EQ(away.status, ImpactStatus::clear) << start;
  }
}

}  // namespace
}  // namespace touchstone
