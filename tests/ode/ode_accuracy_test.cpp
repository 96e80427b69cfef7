#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>
#include <string>
#include <vector>

#include "touchstone/tests/ode/ode_scenes.hpp"

// Errors of ODE 0.16.2 as packaged by Debian 12, measured against a plain separating-axis reference.

namespace touchstone::ode_test {
namespace {

struct Figures {
  int apart = 0, together = 0, missed = 0, phantom = 0, failed = 0, kinds_disagree = 0;
  double worst_missed = 0.0, worst_phantom = 0.0, worst_depth_error = 0.0, median_depth_error = 0.0,
         least_error = 0.0;
};

Figures measure(const char* what, Family family, const Vector3& centre) {
  // ODE answers the same pairs by overlap and by distance.
  const PairScene scene = random_pairs(20000, family, centre, 11);
  const auto narrowphase = registry().make_narrowphase("ode");
  narrowphase->build(scene.solids);
  const Answers overlap = ask(*narrowphase, scene.pairs, scene.poses, Query{});
  const Answers distance = ask(*narrowphase, scene.pairs, scene.poses, Query{.kind = QueryKind::distance});
  Figures figures;
  std::vector<double> errors;
  // Classes against a reference.
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
    // Depths, where both see contact.
    if (depth < 0 || distance.status[i] != PairStatus::overlapping) continue;
    const double error = -distance.geometry[i].separation - depth;
    figures.least_error = std::min(figures.least_error, error);
    errors.push_back(std::abs(error));
  }
  // The errors of depths become a median and a worst.
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

void expect_depths_alone_off(const Figures& figures, double median_below, double worst_from,
                             double worst_to) {
  EXPECT_EQ(figures.missed, 0);
  EXPECT_EQ(figures.phantom, 0);
  EXPECT_EQ(figures.failed, 0);
  EXPECT_EQ(figures.kinds_disagree, 0);
  EXPECT_LT(figures.median_depth_error, median_below);
  EXPECT_GT(figures.worst_depth_error, worst_from);
  EXPECT_LT(figures.worst_depth_error, worst_to);
}

// Depths are never below the least, and up to 0.056 m above it where the 1.05 preference for faces takes a
// worse axis.
void expect_box_figures(const Figures& figures) { expect_depths_alone_off(figures, 1e-9, 0.05, 0.06); }

TEST(OdeAccuracy, BoxesAreClassifiedRightWithDepthsOffByUpTo56Millimetres) {
  expect_box_figures(measure("boxes", Family::boxes, Vector3::Zero()));
}

TEST(OdeAccuracy, BoxesAMegametreOutAreClassifiedTheSame) {
  expect_box_figures(measure("boxes at 1e6", Family::boxes, {1e6, -1e6, 1e6}));
}

// MPR's depth is along a ray from inside the two bodies' Minkowski difference: one pair in a hundred is 0.4 m
// off.
void expect_sheared_figures(const Figures& figures) { expect_depths_alone_off(figures, 1e-3, 0.9, 1.1); }

TEST(OdeAccuracy, ShearedHexahedraAreClassifiedRightWithDepthsOffByUpToAMetre) {
  expect_sheared_figures(measure("sheared", Family::sheared, Vector3::Zero()));
}

TEST(OdeAccuracy, ShearedHexahedraAMegametreOutAreClassifiedTheSame) {
  expect_sheared_figures(measure("sheared at 1e6", Family::sheared, {1e6, -1e6, 1e6}));
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
    const Vector3 p_AB{1.0 + gap, uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
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

struct AlignedCase {
  const char* name;
  Vector3 size_a, size_b, p_AB;
  double depth;  ///< least, by hand
};

constexpr double kThin = 1e-6;

std::vector<AlignedCase> deep_cases() {
  return {{"identical", {1, 1, 1}, {1, 1, 1}, {0, 0, 0}, 1.0},
          {"contained", {1, 1, 1}, {0.2, 0.2, 0.2}, {0.1, 0, 0}, 0.5},
          {"slab", {1, 1, kThin}, {1, 1, kThin}, {0.3, 0.2, 5e-7}, 5e-7},
          {"needle", {1, kThin, kThin}, {kThin, 1, kThin}, {0.3, 0.2, 5e-7}, 5e-7},
          {"tiny", {1e-8, 1e-8, 1e-8}, {1e-8, 1e-8, 1e-8}, {9e-9, 1e-9, 2e-9}, 1e-9},
          {"huge", {1e8, 1e8, 1e8}, {1e8, 1e8, 1e8}, {9e7, 1e7, 2e7}, 1e7}};
}

Answers ask_aligned(const AlignedCase& at, bool convex, QueryKind kind) {
  const auto narrowphase = registry().make_narrowphase("ode");
  const Hexahedron a = Hexahedron::from_size(at.size_a), b = Hexahedron::from_size(at.size_b);
  const std::array<Hexahedron, 2> solids = {convex ? Hexahedron::from_vertices(a.vertices()) : a,
                                            convex ? Hexahedron::from_vertices(b.vertices()) : b};
  narrowphase->build(solids);
  const std::array<Pose, 2> poses = {Pose{}, Pose{Matrix3::Identity(), at.p_AB}};
  const std::array<SolidPair, 1> pair = {{{0, 1}}};
  return ask(*narrowphase, pair, poses, Query{.kind = kind});
}

double depth_error(const AlignedCase& at, bool convex) {
  const Answers answers = ask_aligned(at, convex, QueryKind::distance);
  EXPECT_EQ(answers.status[0], PairStatus::overlapping) << at.name;
  return -answers.geometry[0].separation - at.depth;
}

TEST(OdeAccuracy, AlignedBoxesHaveTheirLeastDepth) {
  for (const AlignedCase& at : deep_cases())
    EXPECT_NEAR(depth_error(at, false) / at.depth, 0.0, 1e-9) << at.name;
}

// MPR's tolerance is an absolute 1e-6: needles 1e-6 thick come out 1e-7 too shallow, cubes of 1e-8 twelve
// times too deep.
TEST(OdeAccuracy, ConvexesAsSmallAsTheToleranceAreOff) {
  for (const AlignedCase& at : deep_cases()) {
    const double error = depth_error(at, true) / at.depth;
    const std::string name = at.name;
    if (name == "needle") {
      EXPECT_NEAR(error, -0.2, 0.01);
    } else if (name == "tiny") {
      EXPECT_NEAR(error, 11.08, 0.1);
    } else {
      EXPECT_NEAR(error, 0.0, 1e-9) << name;
    }
  }
}

// Touching is contact. Boxes are seen to touch, but dBoxBox gives points for faces only; MPR misses all
// three.
TEST(OdeAccuracy, ExactTouch) {
  const Vector3 size(1, 1, 1);
  const AlignedCase face{"face", size, size, {1, 0, 0}, 0.0};
  const AlignedCase edge{"edge", size, size, {1, 1, 0}, 0.0};
  const AlignedCase vertex{"vertex", size, size, {1, 1, 1}, 0.0};
  for (const AlignedCase& at : {face, edge, vertex}) {
    EXPECT_EQ(ask_aligned(at, false, QueryKind::overlap).status[0], PairStatus::overlapping) << at.name;
    EXPECT_EQ(ask_aligned(at, true, QueryKind::overlap).status[0], PairStatus::separated) << at.name;
  }
  EXPECT_EQ(ask_aligned(face, false, QueryKind::distance).status[0], PairStatus::overlapping);
  EXPECT_EQ(ask_aligned(edge, false, QueryKind::distance).status[0], PairStatus::failed);
  EXPECT_EQ(ask_aligned(vertex, false, QueryKind::distance).status[0], PairStatus::failed);
}

// Two sides of each solid between 1e-6 and 1. Convex depths come out up to 1e-6 too shallow and 0.83 m too
// deep.
TEST(OdeAccuracy, SlabsAndNeedlesAreClassifiedRight) {
  const Figures boxes = measure("thin boxes", Family::thin_boxes, Vector3::Zero());
  EXPECT_EQ(boxes.missed + boxes.phantom + boxes.failed + boxes.kinds_disagree, 0);
  EXPECT_LT(boxes.worst_depth_error, 0.03);
  const Figures convexes = measure("thin convexes", Family::thin_convexes, Vector3::Zero());
  EXPECT_EQ(convexes.missed + convexes.phantom + convexes.failed + convexes.kinds_disagree, 0);
  EXPECT_GT(convexes.worst_depth_error, 0.8);
  EXPECT_LT(convexes.worst_depth_error, 0.9);
  EXPECT_LT(convexes.least_error, -5e-7);
  EXPECT_GT(convexes.least_error, -1e-6);
}

// Answers to (a, b) and (b, a): the class agrees, MPR's depth need not.
TEST(OdeAccuracy, SwappedPairs) {
  for (const Family family : {Family::boxes, Family::sheared}) {
    PairScene scene = random_pairs(5000, family, Vector3::Zero(), 13);
    const auto narrowphase = registry().make_narrowphase("ode");
    narrowphase->build(scene.solids);
    const Query query{.kind = QueryKind::distance};
    const Answers forward = ask(*narrowphase, scene.pairs, scene.poses, query);
    for (SolidPair& pair : scene.pairs) std::swap(pair.a, pair.b);
    const Answers backward = ask(*narrowphase, scene.pairs, scene.poses, query);
    int classes = 0, depths = 0;
    double worst = 0.0;
    for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
      classes += forward.status[i] != backward.status[i];
      if (forward.status[i] != PairStatus::overlapping) continue;
      const double change = std::abs(forward.geometry[i].separation - backward.geometry[i].separation);
      depths += change > 1e-9;
      worst = std::max(worst, change);
    }
    const bool boxes = family == Family::boxes;
    std::cout << (boxes ? "boxes" : "sheared") << " swapped: classes " << classes << " depths " << depths
              << " of 5000, worst " << worst << "\n";
    EXPECT_EQ(classes, 0);
    EXPECT_LT(worst, boxes ? 0.06 : 1.1);
  }
}

TEST(OdeAccuracy, RawTimes) {
  for (const bool shear : {false, true}) {
    const PairScene scene = random_pairs(2000, shear ? Family::sheared : Family::boxes, Vector3::Zero(), 12);
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
