#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// A plane n . p + d = 0 with outward unit normal n: negative inside the solid (the paper's equation 2, A x +
/// B y + C z + D).
struct Plane {
  Vector3 normal;
  double offset;  ///< d [m]

  double signed_distance(const Vector3& p) const { return dot(normal, p) + offset; }
};

/// An edge's line p(t) = origin + t * direction; t in [0, 1] is the edge (the paper's equations 1A and 1B).
struct EdgeLine {
  Vector3 origin;
  Vector3 direction;  ///< end - origin, not normalised [m]
};

/// A sphere in the frame that its variable's name gives: sphere_S in a solid's, sphere_O in an object's.
struct Sphere {
  using MovesByBits = Sphere;  ///< see kMovesByBits

  Vector3 centre;
  double radius;  ///< [m]
};

/// Eight world vertices as arrays of coordinates: one 512-bit register each.
struct alignas(64) WorldVertices {
  std::array<double, 8> x, y, z;

  Vector3 vertex(int i) const { return {x[i], y[i], z[i]}; }
};

/// Which bent faces Hexahedron::from_vertices() takes. A bent solid is the hull of its eight vertices all the
/// same, and is checked as that: the limit finds mistakes in the input, no answer depends on it.
enum class WarpPolicy : std::uint8_t {
  refuse,            ///< bends by rounding alone, as of a rotation in doubles: 32 eps * size
  within_tolerance,  ///< bends by a file's decimals: up to Hexahedron::bend_tolerance()
  accept,            ///< any bend
};

/// A validated convex hexahedron in its local frame. Immutable; copies are independent.
///
/// Vertex i has bits (x y z) = (i>>2 & 1, i>>1 & 1, i & 1): 0 is (-,-,-), 1 is (-,-,+), 7 is (+,+,+), as in a
/// box. The six faces and twelve edges follow from the bits: kFaceVertices and kEdgeVertices. A mirrored
/// labelling is relabelled on construction, so the loops of kFaceVertices are always counter-clockwise seen
/// from outside.
///
/// The solid *is* the convex hull of its eight vertices; placed in the world, the convex hull of the
/// eight world vertices as doubles (see world_vertices()).
///
/// With a radius() it is rounded: every point within the radius of that hull, which then is its *core* and
/// may be flat, a segment or a point: a sphere, a capsule, a rounded plate or box. vertices(), faces, edges
/// and size() are the core's; bounding_sphere() encloses the whole solid. Code that reads the vertices only
/// must refuse rounded solids: refuse_rounded().
class Hexahedron {
 public:
  using MovesByBits = Hexahedron;  ///< see kMovesByBits

  static constexpr int kVertices = 8;
  /// Face f: -x, +x, -y, +y, -z, +z; four vertices counter-clockwise from outside.
  static constexpr std::array<std::array<std::uint8_t, 4>, 6> kFaceVertices = {
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  /// Edges 0-3 along x, 4-7 along y, 8-11 along z; from the lower to the higher vertex index.
  static constexpr std::array<std::array<std::uint8_t, 2>, 12> kEdgeVertices = {
      {{0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 1}, {2, 3}, {4, 5}, {6, 7}}};

  /// A box centred on the local origin, vertices +-size/2.
  /// @param size full side lengths along local x, y, z [m], finite and > 0.
  /// @throws InputError naming `name` and the figure.
  static Hexahedron from_size(const Vector3& size, std::string_view name = "box");

  /// A convex hexahedron. The vertices may come in the order above, mirrored, or in any order at all: the
  /// faces are then found from the hull, as the labelling whose twelve edges are edges of the hull and whose
  /// faces bend least, up to bend_tolerance() (32 eps * size on WarpPolicy::refuse). The order given is kept
  /// where it is such a labelling and another would not bend four times less.
  /// Coincident vertices (collapsed edges or faces, e.g. a pyramid) are legal in the order above while the
  /// volume is positive. Faces more than 32 eps * size out of plane make the solid `warped`; `warp` limits
  /// how far they may be.
  /// @throws InputError naming `name`, the face or vertex and the figure: not 8 vertices, not finite, zero
  /// volume, a vertex inside the hull (not convex), bent further than `warp` takes, no hexahedron in any
  /// order, two orders that fit as well.
  static Hexahedron from_vertices(std::span<const Vector3> vertices,
                                  WarpPolicy warp = WarpPolicy::within_tolerance,
                                  std::string_view name = "hexahedron");

  /// How far WarpPolicy::within_tolerance lets a vertex be from its face's plane [m], from the largest
  /// distance between two vertices and the largest |coordinate|: 0.01 size + 2^-23 coordinate, at most
  /// 0.05 size. Rounding each coordinate by up to r moves a vertex off its face's plane, and so bends the
  /// face, by at most sqrt(3) r. Three decimals of a metre (or whole millimetres), r = 0.5 mm, stay below
  /// 0.01 size from a size of 87 mm on; single precision, r = 2^-24 coordinate, stays below the second term.
  static double bend_tolerance(double size, double largest_coordinate);

  /// A sphere about the local origin.
  /// @param radius [m], finite and > 0 (so in all that follow). @throws InputError naming `name` and the
  /// figure.
  static Hexahedron sphere(double radius, std::string_view name = "sphere");
  /// All points within `radius` of a segment of this length along local z, about the local origin: a cylinder
  /// of that length between two half spheres. @param length [m], finite and >= 0.
  static Hexahedron capsule(double radius, double length, std::string_view name = "capsule");
  /// All points within `radius` of a box of these full side lengths about the local origin [m], finite, each
  /// of them >= 0: a zero side gives a rounded plate, two a capsule, three a sphere.
  static Hexahedron rounded_box(const Vector3& core_size, double radius,
                                std::string_view name = "rounded box");
  /// This solid grown by a radius on all sides (padding), which is added to the radius that it has.
  Hexahedron padded(double radius, std::string_view name = "hexahedron") const;

  /// How far the solid reaches beyond its vertices' hull [m]; 0 unless rounded.
  double radius() const { return radius_; }
  bool is_rounded() const { return radius_ > 0.0; }

  const std::array<Vector3, kVertices>& vertices() const { return vertices_; }
  /// True where the vertices are exactly +-half_extents(): made by from_size, or rounded from such a box.
  bool is_box() const { return is_box_; }
  /// Boxes only; zero otherwise [m].
  const Vector3& half_extents() const { return half_extents_; }
  /// Whether a face is more than 32 eps * size out of plane.
  bool is_warped() const { return is_warped_; }
  /// The bend: largest distance of a vertex from its face's plane [m], half of that between the lines through
  /// the face's diagonals. Lifting one corner of a rectangle by h is a bend of h / 4: no plane is nearer to
  /// all four.
  double out_of_plane() const { return out_of_plane_; }
  /// Largest distance between two vertices [m].
  double size() const { return size_; }
  /// Encloses the solid, its radius included: centre of the vertices' bounding box.
  const Sphere& bounding_sphere() const { return bounding_sphere_; }

  /// Outward plane of face f (0-5); a collapsed face has a zero normal. For warped faces: through the face's
  /// centroid, normal across its diagonals.
  const Plane& face_plane(int face) const { return planes_[face]; }
  EdgeLine edge_line(int edge) const;

 private:
  Hexahedron() = default;
  static Hexahedron centred_box(const Vector3& half);
  void finish(const std::array<Vector3, kVertices>& vertices);

  std::array<Vector3, kVertices> vertices_;
  std::array<Plane, 6> planes_;
  Vector3 half_extents_ = Vector3::Zero();
  Sphere bounding_sphere_{Vector3::Zero(), 0.0};
  double size_ = 0.0;
  double radius_ = 0.0;
  double out_of_plane_ = 0.0;
  bool is_box_ = false;
  bool is_warped_ = false;
};

/// Refuses rounded solids, for code that takes hexahedra without a radius only.
/// @param user who refuses ("broadphase 'edge_face'"). @throws InputError naming it, the index of the first
/// rounded solid and its radius.
void refuse_rounded(std::span<const Hexahedron> solids, std::string_view user);

/// The solid's (a rounded one's core's) world vertices, ((R.col0 * x + R.col1 * y) + R.col2 * z) + p each, no
/// contraction. Every check and every engine that is given hulls is given these.
void world_vertices(const Hexahedron& solid, const Pose& X_WS, WorldVertices& out);

/// Largest |coordinate| of the world vertices [m].
double largest_coordinate(const WorldVertices& vertices);

}  // namespace touchstone
