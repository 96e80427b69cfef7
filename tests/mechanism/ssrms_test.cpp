#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/mechanism/reference_overlaps.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

Vector3 tip_at(const Mechanism& arm, const std::vector<double>& q) {
  std::vector<Pose> X(arm.links().size());
  arm.link_poses({}, q, X);
  return X[arm.find_link("tip")].p;
}

TEST(Ssrms, HasThePublishedReachAndMass) {
  const Mechanism arm(make_ssrms());
  EXPECT_EQ(arm.value_count(), 7u);
  EXPECT_EQ(arm.solids().size(), 47u);
  EXPECT_LE(norm(tip_at(arm, std::vector<double>(7, 0)) - Vector3(16.9378, -1.6134, 0)), 1e-14);
  double mass = 0;
  for (const Mechanism::Link& link : arm.links()) mass += link.mass.mass;
  EXPECT_NEAR(mass, 1505, 0.5);
}

// Shoulder pitch 90 deg, elbow back by 90: the lower boom runs along x again, one boom lower.
TEST(Ssrms, ElbowMovesTheTip) {
  const Mechanism arm(make_ssrms());
  const Vector3 tip = tip_at(arm, {0, 0, 90 * kDegree, -90 * kDegree, 0, 0, 0});
  EXPECT_LE(norm(tip - Vector3(16.9378 - 7.11, -1.6134, -7.11)), 1e-13);
}

TEST(Ssrms, RoundPartsHoldTheirCircles) {
  const MechanismDescription arm = make_ssrms();
  double boom = 0, worst = 0;
  for (const FacetFigure& figure : arm.facet_figures) {
    EXPECT_FALSE(figure.inscribed);
    if (figure.hexahedron == "boom") boom = figure.error;
    worst = std::max(worst, figure.error);
  }
  EXPECT_NEAR(boom, 0.175 / std::cos(15 * kDegree) - 0.175, 1e-15);
  EXPECT_NEAR(boom, 6.2e-3, 5e-5);
  EXPECT_NEAR(worst, 17.1e-3, 1e-4);
}

TEST(Ssrms, IsFreeOfItselfStraightAndFoldedButNotCrossed) {
  MechanismDescription description = make_ssrms();
  const auto native = make_native();
  EXPECT_TRUE(find_reference_overlaps(Mechanism(description), *native).empty());
  description.reference = {0, 0, 0, 180 * kDegree, 0, 0, 0};
  const std::vector<ReferenceOverlap> folded = find_reference_overlaps(Mechanism(description), *native);
  EXPECT_TRUE(folded.empty()) << to_string(folded[0], Mechanism(description));
  // Folded, with the wrist turned so that the end effector lies across the booms.
  description.reference = {0, 0, 0, 180 * kDegree, 90 * kDegree, 90 * kDegree, 0};
  const Mechanism crossed(description);
  const std::uint32_t tip_lee = crossed.find_link("tip_lee");
  bool reported = false;
  for (const ReferenceOverlap& overlap : find_reference_overlaps(crossed, *native))
    reported |= crossed.link_of(overlap.solids.a) == tip_lee || crossed.link_of(overlap.solids.b) == tip_lee;
  EXPECT_TRUE(reported);
}

TEST(Ssrms, IsHeldByEitherEnd) {
  const Mechanism arm(make_ssrms());
  const Mechanism turned = arm.with_base("tip");
  const std::vector<double> q = {0.3, -0.4, 0.5, 1.6, -0.7, 0.8, -0.9};
  std::vector<Pose> X(9), Y(9);
  arm.link_poses({}, q, X);
  turned.link_poses(X[8], q, Y);
  for (int link = 0; link < 9; ++link) EXPECT_LE(norm(X[link].p - Y[link].p), 1e-13);
}

}  // namespace
}  // namespace touchstone
