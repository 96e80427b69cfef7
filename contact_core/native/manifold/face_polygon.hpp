#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "touchstone/contact_core/native/common/lanes.hpp"
#include "touchstone/contact_core/native/common/tangent_frame.hpp"
#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

// The contact faces of two solids, projected along the contact normal n: plane convex polygons.

namespace touchstone::native {

/// N numbers, two lanes at a time.
template <int N>
struct Row {
  Double2 d[N / 2];

  double operator[](int i) const { return d[i / 2][i % 2]; }
  void set(int i, double value) { d[i / 2][i % 2] = value; }
};

/// A contact face projected along n, with the corners 0 to count - 1, counter-clockwise seen against n, and
/// edge i from corner i to the next; entries beyond are corner 0 without an edge. A polygon of four has no
/// sharp corner. Of larger ones, each sharp corner comes twice, with a *bevel* between: an edge of no length
/// that has a direction, so that the lines of all edges together stay near the polygon at its tips too.
template <int N>
struct FacePolygon {
  int count;
  Row<N> p_x, p_y, p_z;               ///< corners about the hulls' common origin
  Row<N> x, y;                        ///< corners in the tangent frame
  Row<N> edge_x, edge_y;              ///< to the next corner in the tangent frame, or a bevel's direction
  Row<N> length2;                     ///< of the edge, squared; 0: bevel
  std::array<std::uint8_t, N> label;  ///< see edge_label()
};

/// A face has up to eight corners, two of which can be sharp.
inline constexpr int kMostCorners = 10;

/// The planes of a face through one point: one, or the two of a bent face, between which its solid lies.
struct FacePlanes {
  struct Plane {
    Vector3 normal;  ///< outward, in world, of about unit length
    double inverse;  ///< 1 / normal . n
  };

  Vector3 anchor;  ///< on all of them
  int count;       ///< 1 or 2
  std::array<Plane, 2> of;
};

/// The face of a solid that is clipped: its normal is most along +n (A) or -n (B).
struct ContactFace {
  int face;  ///< index into SolidFeatures::faces
  FacePlanes planes;
  bool is_steep;  ///< see kSteep
  bool swapped;   ///< whether the caller's pair is (b, a): edges are labelled for that
};

/// The caller's label of edge k of a polygon of `count`: 0-7 for the caller's first solid, counter-clockwise
/// seen from outside, 8-15 for its second, clockwise, whichever of them is the check's A.
constexpr std::uint8_t edge_label(int k, int count, bool is_b, bool swapped) {
  const int named = swapped ? (2 * count - 2 - k) % count : k;
  return static_cast<std::uint8_t>(is_b == swapped ? named : 8 + named);
}

using hull_clip::kSharp, hull_clip::kSteep;

/// Finds for each solid the face whose normal is most along n (A) or against it (B); the first of those equal
/// to rounding.
void find_contact_faces(const PosedPair& pair, const Vector3& n, ContactFace& a, ContactFace& b);

/// Both polygons when the faces are quadrangles without sharp corners, neither steep; else false.
bool plain_polygons(const PosedPair& pair, const TangentFrame& frame, const ContactFace& a,
                    const ContactFace& b, FacePolygon<4>& polygon_a, FacePolygon<4>& polygon_b);

/// The polygon of any face. A steep face becomes its edge furthest along sign * n, in both directions, and
/// `face`'s plane the one through it across which n leans least. A bent face that is not convex seen along n
/// becomes the one of its triangles that leans less. Corners within 32 u * extent are joined: false when
/// fewer than two are left, or when a steep face's edge is steep too.
bool general_polygon(const SolidFeatures& solid, const WorldVertices& vertices, double extent,
                     const TangentFrame& frame, double sign, ContactFace& face,
                     FacePolygon<kMostCorners>& polygon);

}  // namespace touchstone::native
