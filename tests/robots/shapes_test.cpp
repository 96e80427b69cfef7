#include "touchstone/adapters/robots/shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

bool is_inside(const RoundPart& part, const Vector3& p) {
  return std::any_of(part.solids.begin(), part.solids.end(), [&](const PlacedHexahedron& placed) {
    for (int face = 0; face < 6; ++face)
      if (placed.solid.face_plane(face).signed_distance(p) > 1e-14) return false;
    return true;
  });
}

/// The farthest corner: the distance from a convex shape is largest at a corner of a convex body.
template <class Distance>
double farthest(const RoundPart& part, const Distance& distance) {
  double most = 0.0;
  for (const PlacedHexahedron& placed : part.solids)
    for (const Vector3& v : placed.solid.vertices()) most = std::max(most, distance(v));
  return most;
}

/// Some thousand directions, poles and seams included.
std::vector<Vector3> directions() {
  std::vector<Vector3> out;
  for (int i = 0; i <= 48; ++i)
    for (int j = 0; j < 96; ++j) {
      const double up = (i / 48.0 - 0.5) * std::numbers::pi, round = j / 48.0 * std::numbers::pi;
      out.emplace_back(std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up));
    }
  return out;
}

TEST(Shapes, ASphereIsHeldWithTheStatedError) {
  for (const int facets : {4, 8, 12, 16}) {
    const RoundPart part = make_sphere(0.5, facets, {}, "ball");
    EXPECT_EQ(part.solids.size(), (facets / 2 - 1) * (facets / 2 - 1));
    for (const Vector3& u : directions())
      for (const double r : {0.0, 0.25, 0.5}) EXPECT_TRUE(is_inside(part, r * u));
    const double off = farthest(part, [](const Vector3& v) { return norm(v) - 0.5; });
    EXPECT_NEAR(part.figures[0].error, off, 1e-14);
    EXPECT_GE(part.figures[0].error, off);
  }
  EXPECT_NEAR(make_sphere(1.0, 8, {}, "ball").figures[0].error, 0.16, 0.01);
  EXPECT_NEAR(make_sphere(1.0, 16, {}, "ball").figures[0].error, 0.04, 0.005);
}

TEST(Shapes, ACapsuleIsHeldWithTheStatedError) {
  const RoundPart part = make_capsule(0.1, 0.6, 8, {}, "rod");
  EXPECT_EQ(part.solids.size(), 9u);
  for (const Vector3& u : directions())
    for (const double z : {-0.3, 0.0, 0.3}) EXPECT_TRUE(is_inside(part, Vector3(0, 0, z) + 0.1 * u));
  const double off = farthest(
      part, [](const Vector3& v) { return norm(v - Vector3(0, 0, std::clamp(v.z(), -0.3, 0.3))) - 0.1; });
  EXPECT_NEAR(part.figures[0].error, off, 1e-14);
}

TEST(Shapes, AnEllipsoidIsHeldAndItsErrorIsABound) {
  const Vector3 half(0.1, 0.2, 0.4);
  const RoundPart part = make_ellipsoid(half, 12, {}, "egg");
  for (const Vector3& u : directions()) EXPECT_TRUE(is_inside(part, u.cwiseProduct(half)));
  const double off = farthest(part, [&](const Vector3& v) {
    double nearest = 1e9;
    for (const Vector3& u : directions()) nearest = std::min(nearest, norm(v - u.cwiseProduct(half)));
    return nearest;
  });
  EXPECT_GE(part.figures[0].error, off - 0.01);  // directions are 4 degrees apart
  EXPECT_LE(part.figures[0].error, 0.4 * 0.08);
}

TEST(Shapes, BadFiguresAreRefused) {
  EXPECT_THROW(make_sphere(0.0, 8, {}, "ball"), InputError);
  EXPECT_THROW(make_sphere(1.0, 6, {}, "ball"), InputError);
  EXPECT_THROW(make_capsule(1.0, -1.0, 8, {}, "rod"), InputError);
  EXPECT_THROW(make_ellipsoid({1, 1, std::nan("")}, 8, {}, "egg"), InputError);
}

}  // namespace
}  // namespace touchstone
