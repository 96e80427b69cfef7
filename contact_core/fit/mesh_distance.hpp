#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// An axis-aligned box [m].
struct Bounds {
  Vector3 low = Vector3::Constant(1e300), high = Vector3::Constant(-1e300);

  void add(const Vector3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  /// Length of the diagonal [m].
  double diagonal() const { return norm(high - low); }
};

/// How far points are from a mesh and from what it encloses.
///
/// The *solid* of a mesh is its triangles, and every point with a winding number other than zero with respect
/// to its closed shells: shells may overlap, and a shell turned inside out is a solid all the same unless
/// another encloses it, when it is a cavity. Open shells are sheets without an inside.
///
/// A tree of bounding boxes. Const calls may come from any thread.
class MeshDistance {
 public:
  /// The triangle nearest to a point, and how far it is.
  struct Nearest {
    double distance;  ///< [m], to rounding: 2^-45 of the largest |coordinate|
    std::uint32_t triangle;
  };

  /// @param mesh welded; copied.
  explicit MeshDistance(const TriangleMesh& mesh);

  const TriangleMesh& mesh() const { return mesh_; }
  const MeshShells& shells() const { return shells_; }
  const Bounds& bounds() const { return bounds_; }
  /// Largest |coordinate| of the mesh [m].
  double largest_coordinate() const { return largest_coordinate_; }

  Nearest nearest(const Vector3& p) const { return nearest_within(p, {1e150, 0}); }
  /// The same, sooner found where this triangle is near.
  Nearest nearest_from(const Vector3& p, std::uint32_t triangle) const {
    return nearest_within(p, {to_triangle(p, triangle), triangle});
  }
  /// Whether the surface is within a distance [m] of a point: sooner known than how far it is.
  bool is_near(const Vector3& p, double distance) const;
  /// Distance of a point to one triangle [m].
  double to_triangle(const Vector3& p, std::uint32_t triangle) const;
  /// The point of a triangle that is nearest to p.
  Vector3 closest_on(const Vector3& p, std::uint32_t triangle) const;
  /// A point of which it is known how far the surface is [m], and how often the closed shells wind about it.
  struct Known {
    Vector3 p;
    double distance;
    int winding;
  };
  /// Returns whether the closed shells wind about all of a tetrahedron, with room for rounding. May return
  /// false where they do.
  ///
  /// Along the segment from a point of it to another the winding number falls by one at each triangle whose
  /// back the first one sees, at most once at each, and nowhere else. Of two such triangles the segment meets
  /// one after the other only where the second one is in front of the first somewhere, and the first one
  /// behind the second; and both at once only where they overlap in one plane. So it is enough that the
  /// winding number is larger at one point than the number of groups of triangles that meet the tetrahedron,
  /// show that point their back, and of which the segment meets one at most.
  /// @param near a known point, from which the number is found faster
  bool is_solid(const std::array<Vector3, 4>& tetrahedron, const Known& near) const;
  bool is_solid(const std::array<Vector3, 4>& tetrahedron) const {
    const Vector3& p = tetrahedron[0];
    return is_solid(tetrahedron, {p, 0.0, 0});
  }
  /// Whether one flat wall, and nothing else, meets a box: every triangle that does is of a closed shell,
  /// within `room` [m] of the plane, and faces along its normal, or all face against it. The plane's part in
  /// the box then is surface throughout. May return false where it is so.
  bool is_one_wall(const Bounds& box, const Plane& plane, double room) const;
  /// How often the closed shells wind about a point that is not on the surface. On it, and within rounding of
  /// it, that of either side.
  int winding(const Vector3& p) const;
  /// The same as winding(), sooner known where a known point is near: by what is between both.
  int winding_near(const Known& known, const Vector3& p) const;
  /// Whether it is not 0.
  bool is_inside(const Vector3& p) const { return winding(p) != 0; }
  /// Distance to the surface, negative inside [m].
  double signed_distance(const Vector3& p) const;
  /// Distance to the solid, 0 inside [m].
  double to_solid(const Vector3& p) const;

 private:
  struct Node {
    Vector3 low, high;
    std::uint32_t first = 0;  ///< of a leaf: into order_; else the left child, the right one follows it
    std::uint32_t count = 0;  ///< triangles of a leaf; 0: inner node
  };
  struct Corners {
    Vector3 a, b, c;
    double edge;  ///< a ray this near to an edge, times the area, is ambiguous; 0: of no closed shell
  };

  Nearest nearest_within(const Vector3& p, Nearest known) const;
  template <class Accepts>
  bool all_near(const Bounds& box, double room, const Accepts& accepts) const;
  void split(std::uint32_t node, std::uint32_t begin, std::uint32_t end);
  /// Nothing on the surface, and within rounding of it.
  std::optional<int> winding_about(const Vector3& p) const;
  std::optional<int> winding_about(const Vector3& p, const Known& near) const;
  /// By how much the winding number at p is larger than at the end of a way; false where the way meets an
  /// edge to rounding.
  /// @param direction unit, no component of it 0
  /// @param length of the way [m]; kEndless: it leaves the mesh
  bool count_crossings(const Vector3& p, const Vector3& direction, double length, int& winding) const;

  TriangleMesh mesh_;
  MeshShells shells_;
  Bounds bounds_;
  double largest_coordinate_ = 0.0;
  bool has_closed_ = false;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;  ///< triangles, those of a leaf together
  std::vector<Corners> corners_;      ///< a triangle, in order_
};

}  // namespace touchstone
