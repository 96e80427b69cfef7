#pragma once

#include "touchstone/contact_core/native/simd/hull_edges.hpp"
#include "touchstone/contact_core/native/simd/line_crossing.hpp"
#include "touchstone/contact_core/native/simd/pair_blocks.hpp"

// Depth, normal and witness points of one pair of hexahedra that overlap; faces, edges or vertices in lanes.
//
// The depth is the least overlap over the facet normals of the Minkowski difference: faces of A, faces of B,
// and pairs of edges whose arcs on the sphere of normals cross (hull_edges.hpp).
//
// Error. Normals are cofactor(R) times the solid's own, edges the differences of vertices; these are the
// hulls' own, about a common origin: as best_facet_axis(). Overlap is certified by a depth above m = 256 u
// extent + 8 u P: the hulls of the rounded vertices are within 16 u extent + 4 u P of the posed solids,
// facets that count as one turn the axis by 16 u and rounding by as much, each over 2 sqrt(3) extent, and a
// projection is right to 12 u * 3 extent.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kHullRoundoffs = 256.0;
constexpr double kHullWitnessRoundoffs = 32.0;
constexpr double kHeightRoundoffs = 16.0;
constexpr double kOffHullRoundoffs = 256.0;

// ---- Witness points

/// A ball within the hull.
struct Ball {
  Point middle;
  double radius;
};

template <class Pack>
TOUCHSTONE_INLINE Ball ball_within(const PosedHull& hull) {
  Point sum = hull.vertex(0);
  for (int i = 1; i < 8; ++i) sum = sum + hull.vertex(i);
  const Point middle = 0.125 * sum;
  return {middle, -highest_over<Pack>(hull, middle, -1)};
}

/// On the face. Where corners are sharp a point near all planes may be far from the hull. But one that lies e
/// beyond them, at a distance d from the middle of a ball of radius r within, is no further than e d / r from
/// it: moved to the middle by the factor r / (r + e) it is within.
template <class Pack>
TOUCHSTONE_INLINE bool is_on_face(const PosedHull& hull, int face, Point p, const Magnitudes& size) {
  const double over = dot(hull.normal(face), p) - hull.height[face], off = over < 0.0 ? -over : over;
  if (!(off <= kHullWitnessRoundoffs * kU * size.extent)) return false;
  const double beyond =  // of p moved onto the face's plane
      highest_over<Pack>(hull, p, face) + off + size.rounding(kHeightRoundoffs);
  if (__builtin_expect(beyond <= 0.0, 1)) return true;
  const Ball ball = ball_within<Pack>(hull);
  const Point d = p - ball.middle;
  return beyond * __builtin_sqrt(dot(d, d)) <= kOffHullRoundoffs * kU * size.position * ball.radius;
}

/// The point of `other` that lies over `base`'s face: the vertex furthest along `direction`, or the mean of
/// those level with it. `offset` leads from it to `base`'s surface.
template <class Pack>
TOUCHSTONE_INLINE bool face_witness(const PosedHull& base, int face, const PosedHull& other, Point direction,
                                    Point offset, const Magnitudes& size, Point& p) {
  const double level = 4 * kU * size.extent;
  double along[8];
  const Projections<Pack> vertices(other.vertices, direction);
  vertices.write(along);
  const double high = vertices.highest();
  Point sum = {0.0, 0.0, 0.0};
  int count = 0;
  for (int i = 0; i < 8; ++i) {
    if (!(along[i] >= high - level)) continue;
    p = other.vertex(i);
    if (is_on_face<Pack>(base, face, p + offset, size)) return true;
    sum = sum + p;
    ++count;
  }
  p = (1.0 / count) * sum;
  return is_on_face<Pack>(base, face, p + offset, size);
}

TOUCHSTONE_INLINE double within_unit(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }
TOUCHSTONE_INLINE double largest_of(Point p) {
  const double v[3] = {p.x, p.y, p.z};
  return largest_of(v);
}

TOUCHSTONE_INLINE bool edge_witness(const PosedHull& A, const PosedHull& B, const HullAxis& axis,
                                    double tolerance, Point& p_A) {
  const Point a0 = A.vertex(A.hull->edge_vertices[0][axis.edge_a]), a = edge_of(A, axis.edge_a);
  const Point b0 = B.vertex(B.hull->edge_vertices[0][axis.edge_b]), b = edge_of(B, axis.edge_b);
  const auto crossing = cross_lines<double>(b0 - a0, a, b, axis.n);
  const double x = within_unit(crossing.x), y = within_unit(crossing.y);
  p_A = a0 + x * a;
  return largest_of(((b0 + y * b) - p_A) - axis.separation * axis.n) <= tolerance;
}

template <class Pack>
TOUCHSTONE_INLINE bool find_witness(const PosedHull& A, const PosedHull& B, const HullAxis& axis,
                                    const Magnitudes& size, Point& p_A) {
  const Point offset = axis.separation * axis.n;
  if (axis.edge_a >= 0) return edge_witness(A, B, axis, kHullWitnessRoundoffs * kU * size.extent, p_A);
  if (axis.face_b >= 0) return face_witness<Pack>(B, axis.face_b, A, axis.n, offset, size, p_A);
  Point p_B;
  const Point back = -1.0 * offset;
  const bool found = face_witness<Pack>(A, axis.face_a, B, -1.0 * axis.n, back, size, p_B);
  p_A = p_B + back;
  return found;
}

/// Verdict, depth and witness along the best axis of all. @param out `unknown` and `nothing` before
template <class Pack>
TOUCHSTONE_INLINE void settle_depth(const PosedHull& A, const PosedHull& B, HullAxis best,
                                    const Magnitudes& size, DepthRecord& out) {
  const double margin = size.rounding(kHullRoundoffs);
  if (best.separation > margin) {
    out.certified = Certified::separated;
    return;
  }
  if (best.separation < -margin) out.certified = Certified::overlapping;
  best.separation = best.separation < 0.0 ? best.separation : 0.0;
  Point p_A{};
  out.known = find_witness<Pack>(A, B, best, size, p_A) ? DepthKnown::witness : DepthKnown::axis;
  out.separation = best.separation;
  out.n[0] = best.n.x, out.n[1] = best.n.y, out.n[2] = best.n.z;
  out.p_A[0] = p_A.x, out.p_A[1] = p_A.y, out.p_A[2] = p_A.z;
}

/// What is known of a pair's faces.
struct FaceStage {
  FaceDepths depths[2];  ///< of A's, of B's
  FaceChoice best;
};

/// @param count_a, count_b the hulls' faces, beside them for compilers
template <class Pack>
TOUCHSTONE_INLINE void compare_faces(const PosedHull& A, int count_a, const PosedHull& B, int count_b,
                                     const Magnitudes& size, FaceStage& out) {
  find_face_depths<Pack>(A, count_a, B, out.depths[0]), find_face_depths<Pack>(B, count_b, A, out.depths[1]);
  out.best = choose_face<Pack>(out.depths, count_a, count_b, size.extent);
}

template <class Pack>
TOUCHSTONE_INLINE void finish_depth(const PosedHull& A, int count_a, const PosedHull& B, int count_b,
                                    const FaceStage& faces, const Magnitudes& size, DepthRecord& out) {
  const bool is_apart = faces.best.separation > size.rounding(kHullRoundoffs);
  out.certified = is_apart ? Certified::separated : Certified::unknown;
  out.known = DepthKnown::nothing;
  out.axis = 0;
  out.is_of_hulls = true;
  if (is_apart) return;
  // Edges that could do better.
  const double depth = -faces.best.separation;
  const unsigned edges_a = edges_in_question<Pack>(A, count_a, faces.depths[0], depth, size);
  const unsigned edges_b = edges_in_question<Pack>(B, count_b, faces.depths[1], depth, size);
  HullAxis best = axis_of<Pack>(faces.best, A, B);
  if (search_edges<Pack>(A, edges_a, B, edges_b, size, best) == EdgeSearch::done)
    settle_depth<Pack>(A, B, best, size, out);
}

template <class Pack>
TOUCHSTONE_INLINE void compute_hull_depth_inline(const HullView& a, const HullView& b, double extent,
                                                 double position, DepthRecord& out) {
  PosedHull A, B;
  pose_faces<Pack>(a, A), pose_faces<Pack>(b, B);
  const Magnitudes size = {extent, position};
  FaceStage faces;
  const int count_a = A.hull->face_count, count_b = B.hull->face_count;
  compare_faces<Pack>(A, count_a, B, count_b, size, faces);
  finish_depth<Pack>(A, count_a, B, count_b, faces, size, out);
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
