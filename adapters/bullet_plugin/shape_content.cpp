#include "touchstone/adapters/bullet_plugin/shape_content.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

std::array<double, 3> full_sides(const btCollisionShape& shape) {
  const btVector3 half = static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin();
  return {2.0 * half.x(), 2.0 * half.y(), 2.0 * half.z()};
}

std::array<double, 3> point(const btConvexHullShape& hull, int i) {
  const btVector3 p = hull.getScaledPoint(i);
  return {p.x(), p.y(), p.z()};
}

bool is_box(const btCollisionShape& shape) { return shape.getShapeType() == BOX_SHAPE_PROXYTYPE; }

/// Null for other shapes.
const btConvexHullShape* as_hull(const btCollisionShape& shape) {
  if (shape.getShapeType() != CONVEX_HULL_SHAPE_PROXYTYPE) return nullptr;
  const auto& hull = static_cast<const btConvexHullShape&>(shape);
  return hull.getNumPoints() == Hexahedron::kVertices ? &hull : nullptr;
}

}  // namespace

std::optional<native::SolidContent> content_of(const btCollisionShape& shape) {
  native::SolidContent content;
  if (is_box(shape)) {
    content.is_box = true;
    content.points[0] = full_sides(shape);
    return content;
  }
  const btConvexHullShape* const hull = as_hull(shape);
  if (hull == nullptr) return std::nullopt;
  for (int i = 0; i < Hexahedron::kVertices; ++i) content.points[i] = point(*hull, i);
  return content;
}

bool is_content_of(const native::SolidContent& content, const btCollisionShape& shape) {
  if (content.is_box) return is_box(shape) && content.points[0] == full_sides(shape);
  const btConvexHullShape* const hull = as_hull(shape);
  if (hull == nullptr) return false;
  bool same = true;
  for (int i = 0; i < Hexahedron::kVertices; ++i) same = same && content.points[i] == point(*hull, i);
  return same;
}

double outer_margin(const btCollisionShape& shape) {
  return is_box(shape) ? 0.0 : static_cast<double>(static_cast<const btConvexHullShape&>(shape).getMargin());
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
