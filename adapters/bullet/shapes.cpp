#include "touchstone/adapters/bullet/shapes.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "touchstone/contact_core/geometry/orientation.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

// GJK, EPA and the box detector multiply up to four lengths; beyond these none of that is a normal number.
constexpr double kSmallestSize = kDouble ? 1e-75 : 1e-9;
constexpr double kLargestSize = kDouble ? 1e75 : 1e9;

[[noreturn]] void reject(std::size_t index, const char* reason) {
  throw InputError("solid " + std::to_string(index) + ": " + reason + " (Bullet, " +
                   (kDouble ? "double" : "single") + " precision)");
}

std::unique_ptr<btConvexShape> make_box(const Hexahedron& solid) {
  const btVector3 half_extents = to_engine(solid.half_extents());
  auto box = std::make_unique<btBoxShape>(half_extents);
  // setMargin(0) subtracts and adds the default 0.04 m: small boxes would lose their size to rounding.
  box->setMargin(btScalar(0));
  box->setImplicitShapeDimensions(half_extents);
  return box;
}

std::unique_ptr<btConvexShape> make_hull(const std::array<Vector3, 8>& vertices) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : vertices) hull->addPoint(to_engine(v), false);
  hull->setMargin(btScalar(0));
  hull->recalcLocalAabb();
  return hull;
}

Shape make_shape(const Hexahedron& solid, std::size_t index) {
  if (!(solid.size() >= kSmallestSize)) reject(index, "too small");
  double reach = 0.0;
  std::array<Vector3, 8> rounded;
  for (int i = 0; i < 8; ++i) {
    reach = std::max(reach, norm(solid.vertices()[i]));
    rounded[i] = from_engine(to_engine(solid.vertices()[i]));
  }
  if (!(reach <= kLargestSize)) reject(index, "too large, or too far from its local origin");
  if (!numerics::has_volume(rounded)) reject(index, "zero volume after rounding to the engine's scalar");
  return {solid.is_box() ? make_box(solid) : make_hull(rounded), solid.is_box(), solid.size(), reach};
}

}  // namespace

std::vector<Shape> make_shapes(std::span<const Hexahedron> solids) {
  refuse_rounded(solids, "bullet");
  std::vector<Shape> shapes;
  shapes.reserve(solids.size());
  for (std::size_t i = 0; i < solids.size(); ++i) shapes.push_back(make_shape(solids[i], i));
  return shapes;
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
