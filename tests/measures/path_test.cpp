#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/paths/path_families.hpp"
#include "touchstone/examples/measures/paths/path_impact.hpp"
#include "touchstone/examples/measures/paths/path_truth.hpp"

// Paths of two solids: their poses, their times of impact, exactly and as a backend finds them.

namespace touchstone::measures {
namespace {

constexpr std::size_t kPoses = 9;

Pose at(double x, double y, double z) { return {Matrix3::Identity(), {x, y, z}}; }

/// A cube of 1 m at rest in the origin, and another that goes from one pose to another.
PairSet one_path(const Pose& from, const Pose& to) {
  PairSet set;
  set.name = "own";
  const Hexahedron cube = Hexahedron::from_size({1, 1, 1});
  append_path(set, "own:0", {cube, cube}, {RigidPath(at(0, 0, 0)), RigidPath::between(from, to)}, kPoses);
  return set;
}

const BackendRegistry& registry() {
  static const BackendRegistry filled = [] {
    BackendRegistry backends;
    register_core(backends);
    return backends;
  }();
  return filled;
}

TEST(PathSet, ItsPosesAreThoseOfItsPathsAndItsEndsGiveThemBack) {
  for (const PairFamily& family : path_families()) {
    const PairSet set = make_path_family(family.name, 3, 5, kPoses);
    ASSERT_EQ(set.pairs.size(), 5 * kPoses);
    for (std::size_t i = 0; i < 5; ++i) {
      const SolidPaths paths = paths_of(set, kPoses, i);
      EXPECT_EQ(paths.id, std::string(family.name) + ":" + std::to_string(i));
      for (std::size_t k = 0; k < kPoses; ++k) {
        const SolidPair pair = set.pairs[i * kPoses + k];
        const double s = static_cast<double>(k) / (kPoses - 1);
        EXPECT_TRUE(has_same_bits(set.poses[pair.a], paths.ways[0].pose_at(s)));
        EXPECT_TRUE(has_same_bits(set.poses[pair.b], paths.ways[1].pose_at(s)));
        EXPECT_EQ(set.ids[i * kPoses + k], paths.id + "@" + std::to_string(k));
      }
    }
  }
  EXPECT_THROW(make_path_family("paths_of_glory", 1, 1, 2), InputError);
}

TEST(PathSet, APathDependsOnItsNumberAlone) {
  const PairSet few = make_path_family("paths_turning", 3, 2, kPoses),
                many = make_path_family("paths_turning", 3, 6, kPoses);
  for (std::size_t i = 0; i < few.poses.size(); ++i)
    EXPECT_TRUE(has_same_bits(few.poses[i], many.poses[i])) << i;
}

class PathImpacts : public testing::Test {
 protected:
  void SetUp() override {
    oracle = make_exact_oracle();
    if (!oracle) GTEST_SKIP() << "a build without exact";
  }
  PathTruth truth(const PairSet& set) const { return compute_path_truth(set, kPoses, *oracle, 1).front(); }

  std::unique_ptr<Oracle> oracle;
};

TEST_F(PathImpacts, StraightOnTheTruthIsTheClosedForm) {
  // Faces meet at x = 1, a third of the way from 3 to -3; the bracket is as wide as its gap.
  const PathTruth met = truth(one_path(at(3, 0.2, 0.1), at(-3, 0.2, 0.1)));
  ASSERT_EQ(met.path_class, PathClass::meets);
  EXPECT_LE(met.lo, 1.0 / 3);
  EXPECT_GE(met.hi, 1.0 / 3);
  EXPECT_LE(met.hi - met.lo, 2 * kProofGap);
}

TEST_F(PathImpacts, TurningTheTruthIsTheClosedForm) {
  // A cube beside the other turns by 45 degrees about z: its corner comes to x = 0.5 once
  // sqrt(1/2) cos(pi / 4 - angle) is its distance less that.
  const double angle = 0.3, reach = std::sqrt(0.5) * std::cos(0.25 * M_PI - angle);
  Pose turned = at(0.5 + reach, 0, 0);
  turned.R << std::cos(0.25 * M_PI), -std::sin(0.25 * M_PI), 0, std::sin(0.25 * M_PI), std::cos(0.25 * M_PI),
      0, 0, 0, 1;
  const PathTruth met = truth(one_path(at(0.5 + reach, 0, 0), turned));
  ASSERT_EQ(met.path_class, PathClass::meets);
  EXPECT_NEAR(met.lo, angle / (0.25 * M_PI), 1e-11);
  EXPECT_LE(met.hi - met.lo, 1e-11);
}

TEST_F(PathImpacts, WhatPassesIsClearAndWhatBeginsInContactIsOpen) {
  EXPECT_EQ(truth(one_path(at(3, 1.001, 0), at(-3, 1.001, 0))).path_class, PathClass::clear);
  EXPECT_EQ(truth(one_path(at(0.9, 0, 0), at(3, 0, 0))).path_class, PathClass::open);
  EXPECT_EQ(truth(one_path(at(1, 0, 0), at(3, 0, 0))).path_class, PathClass::open);  // touching is contact
}

TEST_F(PathImpacts, NativeStopsBeforeTheContactWithinItsGap) {
  const PairSet set = make_path_family("paths_turning", 11, 30, kPoses);
  const std::vector<PathTruth> truths = compute_path_truth(set, kPoses, *oracle, 2);
  const PathAnswers answers = run_paths(registry().narrowphase("native"), set, kPoses);
  std::size_t met = 0;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const Impact& impact = answers.impacts[i].value();
    EXPECT_EQ(impact.check, MotionCheck::proven);
    EXPECT_EQ(impact.status == ImpactStatus::blocked, truths[i].path_class == PathClass::meets) << i;
    if (truths[i].path_class != PathClass::meets) continue;
    ++met;
    EXPECT_LE(impact.lo, truths[i].hi);
    const PosedPair posed = posed_at(paths_of(set, kPoses, i), impact.lo);
    EXPECT_LE(oracle->truth(posed.a, posed.b).separation, answers.gaps[i]);
  }
  EXPECT_GT(met, 5u);
  EXPECT_LT(met, 30u);
}

TEST(PathRun, ABackendWithoutSeparationsJudgesPoses) {
  const PairSet set = one_path(at(3, 0.2, 0.1), at(-3, 0.2, 0.1));
  const PathAnswers answers = run_paths(registry().narrowphase("edge_face"), set, kPoses);
  ASSERT_TRUE(answers.impacts.front());
  EXPECT_EQ(answers.impacts.front()->check, MotionCheck::sampled);
}

}  // namespace
}  // namespace touchstone::measures
