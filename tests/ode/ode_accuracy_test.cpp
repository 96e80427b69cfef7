#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>

#include "tests/ode/ode_scenes.hpp"

// What ODE 0.16.2 as packaged by Debian 12 gets wrong, measured against a plain separating-axis reference.

namespace touchstone::ode_test {
namespace {

struct Figures {
  int apart = 0, together = 0, missed = 0, phantom = 0, failed = 0, kinds_disagree = 0;
  double worst_missed = 0.0, worst_phantom = 0.0, worst_depth_error = 0.0, median_depth_error = 0.0,
         least_error = 0.0;
};

Figures measure(const char* what, bool shear, const Vector3& centre) {
  const PairScene scene = random_pairs(20000, shear, centre, 11);
  const auto narrowphase = registry().make_narrowphase("ode");
  narrowphase->build(scene.solids);
  const Answers overlap = ask(*narrowphase, scene.pairs, scene.poses, Query{});
  const Answers distance = ask(*narrowphase, scene.pairs, scene.poses, Query{.kind = QueryKind::distance});
  Figures figures;
  std::vector<double> errors;
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const double depth = reference_depth(scene.solids[2 * i], scene.poses[2 * i], scene.solids[2 * i + 1],
                                         scene.poses[2 * i + 1]);
    const bool seen = overlap.status[i] == PairStatus::overlapping;
    (depth >= 0 ? figures.together : figures.apart) += 1;
    if (depth >= 0 && !seen)
      figures.missed += 1, figures.worst_missed = std::max(figures.worst_missed, depth);
    if (depth < 0 && seen)
      figures.phantom += 1, figures.worst_phantom = std::max(figures.worst_phantom, -depth);
    figures.failed += distance.status[i] == PairStatus::failed;
    figures.kinds_disagree += seen != (distance.status[i] == PairStatus::overlapping);
    if (depth < 0 || distance.status[i] != PairStatus::overlapping) continue;
    const double error = -distance.geometry[i].separation - depth;
    figures.least_error = std::min(figures.least_error, error);
    errors.push_back(std::abs(error));
  }
  std::sort(errors.begin(), errors.end());
  figures.worst_depth_error = errors.back();
  figures.median_depth_error = errors[errors.size() / 2];
  std::cout << what << ": together " << figures.together << " apart " << figures.apart << " missed "
            << figures.missed << " (deepest " << figures.worst_missed << " m) phantom " << figures.phantom
            << " (furthest " << figures.worst_phantom << " m) failed " << figures.failed << " kinds disagree "
            << figures.kinds_disagree << " depth error median " << figures.median_depth_error << " p99 "
            << errors[errors.size() * 99 / 100] << " worst " << figures.worst_depth_error << " least "
            << figures.least_error << "\n";
  return figures;
}

// Depths are never below the least, and up to 0.056 m above it where the 1.05 preference for faces takes a
// worse axis.
void expect_box_figures(const Figures& figures) {
  EXPECT_EQ(figures.missed, 0);
  EXPECT_EQ(figures.phantom, 0);
  EXPECT_EQ(figures.failed, 0);
  EXPECT_EQ(figures.kinds_disagree, 0);
  EXPECT_LT(figures.median_depth_error, 1e-9);
  EXPECT_GT(figures.worst_depth_error, 0.05);
  EXPECT_LT(figures.worst_depth_error, 0.06);
}

TEST(OdeAccuracy, BoxesAreClassifiedRightWithDepthsOffByUpTo56Millimetres) {
  expect_box_figures(measure("boxes", false, Vector3::Zero()));
}

TEST(OdeAccuracy, BoxesAMegametreOutAreClassifiedTheSame) {
  expect_box_figures(measure("boxes at 1e6", false, {1e6, -1e6, 1e6}));
}

// MPR's depth is along a ray from inside the two bodies' Minkowski difference: one pair in a hundred is 0.4 m
// off.
void expect_sheared_figures(const Figures& figures) {
  EXPECT_EQ(figures.missed, 0);
  EXPECT_EQ(figures.phantom, 0);
  EXPECT_EQ(figures.failed, 0);
  EXPECT_EQ(figures.kinds_disagree, 0);
  EXPECT_LT(figures.median_depth_error, 1e-3);
  EXPECT_GT(figures.worst_depth_error, 0.9);
  EXPECT_LT(figures.worst_depth_error, 1.1);
}

TEST(OdeAccuracy, ShearedHexahedraAreClassifiedRightWithDepthsOffByUpToAMetre) {
  expect_sheared_figures(measure("sheared", true, Vector3::Zero()));
}

TEST(OdeAccuracy, ShearedHexahedraAMegametreOutAreClassifiedTheSame) {
  expect_sheared_figures(measure("sheared at 1e6", true, {1e6, -1e6, 1e6}));
}

struct GapFigures {
  int missed = 0;
  int phantom = 0;
};

/// Unit cubes turned together, B `gap` off A along A's x axis: 1000 attitudes and lateral offsets.
GapFigures near_touching(bool convex, double gap) {
  const auto narrowphase = registry().make_narrowphase("ode");
  const Hexahedron cube = convex ? convex_cube() : Hexahedron::from_size({1, 1, 1});
  const std::array<Hexahedron, 2> solids = {cube, cube};
  narrowphase->build(solids);
  std::mt19937_64 random(21);
  const std::array<SolidPair, 1> pair = {{{0, 1}}};
  GapFigures figures;
  for (int i = 0; i < 1000; ++i) {
    const Pose X_WA = random_pose(random, Vector3::Zero(), 1.0);
    const Vector3 p_AB(1.0 + gap, uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5));
    const std::array<Pose, 2> poses = {X_WA, Pose{X_WA.R, transform(X_WA, p_AB)}};
    const bool seen = ask(*narrowphase, pair, poses, Query{}).status[0] == PairStatus::overlapping;
    figures.missed += gap < 0.0 && !seen;
    figures.phantom += gap > 0.0 && seen;
  }
  return figures;
}

TEST(OdeAccuracy, RestingFacesByGap) {
  for (const bool convex : {false, true}) {
    for (const double size : {1e-3, 1e-7, 1e-10, 1e-12}) {
      const GapFigures overlapping = near_touching(convex, -size);
      const GapFigures apart = near_touching(convex, size);
      std::cout << (convex ? "convex" : "box") << " gap " << size << ": missed " << overlapping.missed
                << " phantom " << apart.phantom << " of 1000\n";
      EXPECT_EQ(overlapping.missed, 0);
      EXPECT_EQ(apart.phantom, 0);
    }
  }
}

TEST(OdeAccuracy, RawTimes) {
  for (const bool shear : {false, true}) {
    const PairScene scene = random_pairs(2000, shear, Vector3::Zero(), 12);
    const auto raw = registry().narrowphase("ode").make_raw();
    raw->build(scene.solids);
    raw->set_poses(scene.poses);
    for (const QueryKind kind : {QueryKind::overlap, QueryKind::manifold}) {
      double best = 1e300;
      std::size_t in_contact = 0;
      for (int i = 0; i < 20; ++i) {
        const auto start = std::chrono::steady_clock::now();
        in_contact = raw->run(scene.pairs, kind);
        best = std::min(
            best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
      }
      std::cout << (shear ? "sheared " : "boxes ") << to_string(kind) << ' ' << best / 2000 << " ns\n";
      EXPECT_GT(in_contact, 0u);
      EXPECT_LT(in_contact, scene.pairs.size());
    }
  }
}

}  // namespace
}  // namespace touchstone::ode_test
