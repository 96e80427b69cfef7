// The scenes that come with the project against answers derived by hand. The check here is an independent
// brute-force separating-axis test over all directions of vertex triples and edge pairs; it shares no code
// with the backends.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

Scene scene(const std::string& file, const SceneParameters& parameters = {}) {
  return load_scene(std::string(TOUCHSTONE_SCENES) + "/" + file, parameters);
}

void widen(const WorldVertices& a, const WorldVertices& b, const Vector3& axis, double& best) {
  const double length = norm(axis);
  if (length < 1e-12) return;
  double low_a = kInfinity, high_a = -low_a, low_b = low_a, high_b = -low_a;
  for (int i = 0; i < 8; ++i) {
    const double pa = dot(axis, a.vertex(i)), pb = dot(axis, b.vertex(i));
    low_a = std::min(low_a, pa), high_a = std::max(high_a, pa);
    low_b = std::min(low_b, pb), high_b = std::max(high_b, pb);
  }
  best = std::max(best, std::max(low_b - high_a, low_a - high_b) / length);
}

// Greatest separation over the face normals and edge pairs: the signed distance where the solids overlap, and
// with the right sign everywhere.
double greatest_separation(const WorldVertices& a, const WorldVertices& b) {
  double best = -kInfinity;
  for (const WorldVertices* w : {&a, &b})
    for (const auto& f : Hexahedron::kFaceVertices)
      widen(a, b, cross(w->vertex(f[2]) - w->vertex(f[0]), w->vertex(f[3]) - w->vertex(f[1])), best);
  for (const auto& e : Hexahedron::kEdgeVertices)
    for (const auto& g : Hexahedron::kEdgeVertices)
      widen(a, b, cross(a.vertex(e[1]) - a.vertex(e[0]), b.vertex(g[1]) - b.vertex(g[0])), best);
  return best;
}

// Least over the checked pairs; far pairs are skipped by their spheres.
double clearance(const SceneInstance& instance, double time) {
  std::vector<Pose> poses(instance.solids().size());
  instance.poses_at(time, poses);
  std::vector<WorldVertices> world(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) world_vertices(instance.solids()[i], poses[i], world[i]);
  double least = kInfinity;
  for (const SolidPair& pair : instance.checked_pairs())
    least = std::min(least, greatest_separation(world[pair.a], world[pair.b]));
  return least;
}

// First time in [from, to] with contact, by steps and bisection; contact must persist over a step to be
// found.
std::optional<double> first_contact(const SceneInstance& instance, double from, double to, double step) {
  double clear = from;
  if (clearance(instance, clear) <= 0.0) return from;
  while (clear < to) {
    double contact = std::min(clear + step, to);
    if (clearance(instance, contact) > 0.0) {
      clear = contact;
      continue;
    }
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (clear + contact);
      (clearance(instance, middle) > 0.0 ? clear : contact) = middle;
    }
    return contact;
  }
  return std::nullopt;
}

TEST(GrappleApproach, CentredTheMouthMeetsThePlateAt25Seconds) {
  const Scene grapple = scene("grapple_approach.yaml");
  EXPECT_EQ(grapple.policy, ContactPolicy::advance);
  EXPECT_EQ(grapple.frame_count(), 26u * 50 + 1);
  const std::optional<double> time = first_contact(SceneInstance(grapple), 0.0, 26.0, 0.5);
  ASSERT_TRUE(time);
  EXPECT_NEAR(*time, 25.0, 1e-12);
}

TEST(GrappleApproach, OffsetTheRimMeetsTheTaper) {
  const Scene grapple = scene("grapple_approach.yaml", {{"offset", 0.090}});
  // The taper's half width is 0.019 - (z - 0.25443) 0.014 / 0.019; the facet is 0.100 - 0.090 from the axis.
  const double z = 0.25443 + (0.019 - 0.010) * 0.019 / 0.014;
  const std::optional<double> time = first_contact(SceneInstance(grapple), 0.0, 26.0, 0.5);
  ASSERT_TRUE(time);
  EXPECT_NEAR(*time, (0.5 - z) / 0.02, 1e-11);
  EXPECT_NEAR(*time, 11.667786, 1e-6);
}

TEST(GrappleApproach, LargestClearingOffsetIs81Millimetres) {
  const Scene inside = scene("grapple_approach.yaml", {{"offset", 0.081 - 1e-9}});
  EXPECT_NEAR(first_contact(SceneInstance(inside), 0.0, 26.0, 0.5).value(), 25.0, 1e-12);
  const Scene outside = scene("grapple_approach.yaml", {{"offset", 0.081 + 1e-6}});
  EXPECT_NEAR(first_contact(SceneInstance(outside), 0.0, 26.0, 0.1).value(), (0.5 - 0.25443) / 0.02, 1e-3);
}

TEST(GrappleApproach, ReportsTheFacetErrorAndFollowsTheFacetCount) {
  const Scene grapple = scene("grapple_approach.yaml", {{"facets", 24}});
  EXPECT_EQ(grapple.objects[1].tree.solids().size(), 24u);
  ASSERT_EQ(grapple.facet_figures.size(), 2u);
  EXPECT_EQ(grapple.facet_figures[1].radius, 0.100);
  EXPECT_FALSE(grapple.facet_figures[1].inscribed);
  EXPECT_NEAR(grapple.facet_figures[1].error, 0.100 * (1.0 / std::cos(std::numbers::pi / 24) - 1.0), 1e-17);
}

TEST(OruInsertion, ClearsAt2Point9MillimetresAndBottoms) {
  const Scene insertion = scene("oru_insertion.yaml", {{"offset", 0.0029}, {"lift", 0.01}});
  const std::optional<double> time = first_contact(SceneInstance(insertion), 0.0, 27.0, 0.25);
  ASSERT_TRUE(time);
  EXPECT_NEAR(*time, 26.25 + 0.01 / 0.02, 1e-12);
  const Scene from_mouth = scene("oru_insertion.yaml", {{"offset", 0.0029}});
  EXPECT_NEAR(first_contact(SceneInstance(from_mouth), 0.0, 27.0, 0.25).value(), 26.25, 1e-12);
}

TEST(OruInsertion, MeetsTheRimAtEntryAt3Point1Millimetres) {
  const Scene insertion = scene("oru_insertion.yaml", {{"offset", 0.0031}, {"lift", 0.01}});
  EXPECT_NEAR(first_contact(SceneInstance(insertion), 0.0, 27.0, 0.05).value(), 0.5, 1e-12);
}

TEST(OruInsertion, TiltedMeetsTheRimAtTheClosedFormDepth) {
  const double depths[] = {0.345771, 0.175879, 0.093924};
  const double tilts[] = {0.5, 1.0, 2.0};
  for (int i = 0; i < 3; ++i) {
    const double t = tilts[i] * kDegree;
    const double h = (0.919 / 2 * (1 - std::cos(t)) + 0.003) / std::tan(t);
    const Scene insertion = scene("oru_insertion.yaml", {{"tilt", tilts[i]}});
    const double time = first_contact(SceneInstance(insertion), 0.0, 27.0, 0.25).value();
    EXPECT_NEAR(0.919 / 2 * std::sin(t) + 0.02 * time, h, 1e-12) << tilts[i];
    EXPECT_NEAR(h, depths[i], 1e-6) << tilts[i];
  }
}

TEST(ElbowIntoLab, TouchesAtTheClosedFormAngleAndClearsAtTheSame) {
  const Scene elbow = scene("elbow_into_lab.yaml");
  EXPECT_EQ(elbow.policy, ContactPolicy::cue);
  const SceneInstance instance(elbow);
  const double time = first_contact(instance, 0.0, 3.0, 0.1).value();
  const double a = 4.0 * kDegree * time;
  EXPECT_NEAR(7.11 * std::sin(a) + 0.175 * std::cos(a), 1.3589, 1e-14);
  EXPECT_NEAR(time, 2.401282, 1e-6);
  EXPECT_NEAR(a / kDegree, 9.605129, 1e-6);
  EXPECT_NEAR(clearance(instance, 3.0),
              -(7.11 * std::sin(12 * kDegree) + 0.175 * std::cos(12 * kDegree) - 1.3589), 1e-14);
  EXPECT_NEAR(clearance(instance, 3.0), -0.290528, 1e-6);
  EXPECT_LT(clearance(instance, 6.0 - time - 1e-9), 0.0);
  EXPECT_GT(clearance(instance, 6.0 - time + 1e-9), 0.0);
}

/// Engines whose check knows boxes alone take them.
TEST(ContainedObject, WallsAreBoxes) {
  const Scene walls = scene("contained_walls.yaml");
  std::size_t boxes = 0;
  for (const SceneObject& object : walls.objects)
    for (const PlacedHexahedron& placed : object.tree.solids()) {
      if (placed.name.find('.') == std::string::npos) continue;
      ASSERT_TRUE(placed.solid.is_box()) << placed.name;
      ++boxes;
      // The face inside is where the file puts it.
      const int axis = placed.name[placed.name.size() - 1] - 'x';
      const double inner = std::array{0.52, 0.4545, 0.2575}[static_cast<std::size_t>(axis)];
      EXPECT_NEAR(std::abs(placed.X_OS.p(axis)) - placed.solid.half_extents()(axis), inner, 2e-16);
    }
  EXPECT_EQ(boxes, 6u);
}

TEST(ContainedObject, IsContactInTheSolidBoxAndNoneBetweenWalls) {
  const Scene solid = scene("contained_solid.yaml");
  EXPECT_NEAR(clearance(SceneInstance(solid), 0.0), -0.2725, 1e-15);
  const Scene walls = scene("contained_walls.yaml");
  const SceneInstance instance(walls);
  EXPECT_EQ(instance.solids().size(), 7u);
  EXPECT_NEAR(clearance(instance, 0.0), 0.2475, 1e-15);
}

}  // namespace
}  // namespace touchstone
