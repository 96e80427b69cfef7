#pragma once

#include <optional>
#include <vector>

#include "touchstone/adapters/cover_proof/exact_cover.hpp"
#include "touchstone/adapters/cover_proof/triangle_boxes.hpp"

// Private to this folder.

namespace touchstone::cover_proof {

/// Winding numbers of a mesh's closed shells, exactly.
class SolidSide {
 public:
  /// @param mesh and grid must outlive this
  SolidSide(const TriangleMesh& mesh, const Grid& grid);

  bool has_closed_shells() const { return has_closed_; }
  /// How often the closed shells wind about a point just beyond p, where a ray along +-`axis` begins. Nothing
  /// where the ray meets an edge.
  std::optional<int> winding_beyond(const Point& p, int axis, bool is_upward) const;
  /// The same, sooner: signs that doubles leave open are decided in integers.
  std::optional<int> winding_beyond(const Vector3& p, int axis, bool is_upward) const;
  /// Parts of a piece of a facet; the closed shells pass into the facet's outer side in none of them. Just
  /// beyond a part the winding number is the same everywhere.
  std::vector<Polygon> uncrossed(const Polygon& piece, const FacetPlane& facet) const;
  /// Whether they wind about p, from which every triangle is at least `clearance` away [m]. Where rays from p
  /// meet edges, other points of that ball are asked.
  bool is_inside(const Vector3& p, double clearance) const;
  /// The winding number at p, which is on no triangle; nothing where each ray from it meets an edge.
  std::optional<int> winding_about(const Vector3& p) const;
  /// Whether p is surely on the side of a triangle's plane from which the triangle is counter-clockwise.
  bool is_before(std::uint32_t triangle, const Vector3& p) const;
  /// Whether all of a triangle is on the side of another one's plane that `sign` names, 1: from which that
  /// one is counter-clockwise, or on the plane.
  bool is_all_on(std::uint32_t plane, std::uint32_t triangle, int sign) const;
  /// False where no way but some through edges passes both triangles at one place and in one direction: they
  /// are not in one plane, or face oppositely, or an edge of one has all of the other beside it.
  bool may_be_passed_at_once(std::uint32_t first, std::uint32_t second) const;

 private:
  /// A triangle's part of the winding number; nothing where the ray meets an edge of it.
  std::optional<int> crossing(std::uint32_t triangle, const Point& p, int axis, bool is_upward) const;
  std::vector<std::uint32_t> closed_triangles() const;

  const TriangleMesh& mesh_;
  const Grid& grid_;
  TriangleBoxes boxes_;
  bool has_closed_;
};

}  // namespace touchstone::cover_proof
