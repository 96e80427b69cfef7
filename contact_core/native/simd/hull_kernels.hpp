#pragma once

#include "touchstone/contact_core/native/simd/line_crossing.hpp"
#include "touchstone/contact_core/native/simd/pair_blocks.hpp"

// Depth, normal and witness points of one pair of hexahedra that overlap; faces or edges in lanes.
//
// The depth is the least overlap over the facet normals of the Minkowski difference: faces of A, faces of B,
// and pairs of edges whose arcs on the sphere of normals cross (Gregorius, GDC 2013). With e the edge's
// direction along the loop of its first face, u1, u2 the outward normals beside it, and f, w1, w2 the same of
// B, the arcs cross when f . u1, f . u2 and e . w1, e . w2 have the signs +, -, +, - or all of them turned;
// the outward normal is then e x f or its negative. An edge of A whose two faces both leave B's middle
// deeper below them than the least overlap known less the radius of a ball about the middle within B is
// passed over: on its arc no overlap is less. So for B. The arc's normals are a u1 + b u2, a + b >= 1, so
// this holds however far apart u1 and u2 are, as long as the heights as computed exceed that by what they may
// be off: a normal by 32 u (16 of them facets that count as one, solid_features.hpp), vertices beside the
// plane by 16 u, for points up to 2 sqrt(3) extent apart, and the products by 12 u extent: 180 u extent, the
// radius by as much, and both by what the world vertices' rounding takes.
//
// A pair of edges whose signs are uncertain (closer to 0 than 2^-40) is kept. The separation of two edges'
// own vertices along their common normal is never less than that of the hulls, so a kept pair is out of
// question when its own overlap, less its rounding, exceeds the best; else the hulls are projected, and what
// counts is the projections' separation. No answer rests on the signs but through what they leave out. Edges
// at a sine below 2^-4 that could be the best leave the pair to scalar code; below 4 u they carry no
// direction.
//
// Error. Normals are cofactor(R) times the solid's own, edges R times theirs; vertices are the hulls' own,
// about a common origin: as best_facet_axis(). Overlap is certified by a depth above m = 256 u extent + 8 u
// P: the hulls of the rounded vertices are within 16 u extent + 4 u P of the posed solids, facets that count
// as one turn the axis by 16 u and rounding by as much, each over 2 sqrt(3) extent, and a projection is right
// to 12 u * 3 extent.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kHullRoundoffs = 256.0;
constexpr double kHullPositionRoundoffs = 8.0;
constexpr double kPruneRoundoffs = 512.0;
constexpr double kEdgeRoundoffs = 64.0;
constexpr double kTieOfExtent = 2.0;
constexpr double kUncertainSign = 0x1p-40;
constexpr double kShortCross2 = 0x1p-8;
constexpr double kNoCross2 = 16 * kU * kU;
constexpr double kHullWitnessRoundoffs = 32.0;
constexpr double kHeightRoundoffs = 16.0;
constexpr double kOffHullRoundoffs = 256.0;

using Point = Vector3Of<double>;

/// See compute_hull_depth.
struct Magnitudes {
  double extent, position;

  /// `of_extent` u of the extent, and the world vertices' rounding.
  TOUCHSTONE_INLINE double rounding(double of_extent) const {
    return of_extent * kU * extent + kHullPositionRoundoffs * kU * position;
  }
};

/// A solid's features in the world.
struct PosedHull {
  const HullRecord* hull;
  const double* vertices;  // x of eight, y of eight, z of eight
  alignas(64) double nx[16], ny[16], nz[16], height[16];
  alignas(64) double ex[24], ey[24], ez[24];
  Point middle;
  double radius;  // of a ball about the middle that lies within

  TOUCHSTONE_INLINE Point vertex(int i) const { return {vertices[i], vertices[8 + i], vertices[16 + i]}; }
  TOUCHSTONE_INLINE Point normal(int f) const { return {nx[f], ny[f], nz[f]}; }
  TOUCHSTONE_INLINE Point edge(int e) const { return {ex[e], ey[e], ez[e]}; }
};

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> rotated(const double* R, const double* x, const double* y,
                                          const double* z) {
  const Pack px = load<Pack>(x), py = load<Pack>(y), pz = load<Pack>(z);
  return {(all<Pack>(R[0]) * px + all<Pack>(R[3]) * py) + all<Pack>(R[6]) * pz,
          (all<Pack>(R[1]) * px + all<Pack>(R[4]) * py) + all<Pack>(R[7]) * pz,
          (all<Pack>(R[2]) * px + all<Pack>(R[5]) * py) + all<Pack>(R[8]) * pz};
}

template <class Pack>
TOUCHSTONE_INLINE void pose_hull(const HullView& view, PosedHull& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const HullRecord& hull = *view.hull;
  out.hull = &hull, out.vertices = view.vertices;
  const double* R = view.R;
  double N[9];
  for (int i = 0; i < 3; ++i) {
    const double *p = R + 3 * ((i + 1) % 3), *q = R + 3 * ((i + 2) % 3);
    const Point c = cross(Point{p[0], p[1], p[2]}, Point{q[0], q[1], q[2]});
    N[3 * i] = c.x, N[3 * i + 1] = c.y, N[3 * i + 2] = c.z;
  }
  for (int f = 0; f < hull.face_count; f += kLanes) {
    Vector3Of<Pack> n = rotated<Pack>(N, hull.normal_x + f, hull.normal_y + f, hull.normal_z + f);
    n = (all<Pack>(1.0) / square_root(dot(n, n))) * n;
    store(n.x, out.nx + f), store(n.y, out.ny + f), store(n.z, out.nz + f);
  }
  for (int f = 0; f < hull.face_count; ++f)
    out.height[f] = dot(out.normal(f), out.vertex(hull.face_vertex[f]));
  for (int e = 0; e < hull.edge_count; e += kLanes) {
    const Vector3Of<Pack> d = rotated<Pack>(R, hull.edge_x + e, hull.edge_y + e, hull.edge_z + e);
    store(d.x, out.ex + e), store(d.y, out.ey + e), store(d.z, out.ez + e);
  }
}

/// The separation of `other` from each face of `base` (negative: inside), and its middle's depth below it.
template <class Pack>
TOUCHSTONE_INLINE void face_separations(const PosedHull& base, const PosedHull& other, Point middle,
                                        double (&separation)[16], double (&below)[16]) {
  for (int f = 0; f < base.hull->face_count; f += Traits<Pack>::lanes) {
    const Vector3Of<Pack> n = {load<Pack>(base.nx + f), load<Pack>(base.ny + f), load<Pack>(base.nz + f)};
    const Pack height = load<Pack>(base.height + f);
    Pack low = all<Pack>(__builtin_inf());
    for (int i = 0; i < 8; ++i) {
      const Point p = other.vertex(i);
      low = least(low, dot(n, Vector3Of<Pack>{all<Pack>(p.x), all<Pack>(p.y), all<Pack>(p.z)}));
    }
    store(low - height, separation + f);
    store(height - dot(n, Vector3Of<Pack>{all<Pack>(middle.x), all<Pack>(middle.y), all<Pack>(middle.z)}),
          below + f);
  }
}

/// How far p lies outside each face.
template <class Pack>
TOUCHSTONE_INLINE void heights_over(const PosedHull& hull, Point p, double (&out)[16]) {
  for (int f = 0; f < hull.hull->face_count; f += Traits<Pack>::lanes)
    store(dot(Vector3Of<Pack>{load<Pack>(hull.nx + f), load<Pack>(hull.ny + f), load<Pack>(hull.nz + f)},
              Vector3Of<Pack>{all<Pack>(p.x), all<Pack>(p.y), all<Pack>(p.z)}) -
              load<Pack>(hull.height + f),
          out + f);
}

template <class Pack>
TOUCHSTONE_INLINE void find_middle(PosedHull& hull) {
  Point sum = hull.vertex(0);
  for (int i = 1; i < 8; ++i) sum = sum + hull.vertex(i);
  hull.middle = 0.125 * sum;
  double height[16];
  heights_over<Pack>(hull, hull.middle, height);
  hull.radius = __builtin_inf();
  for (int f = 0; f < hull.hull->face_count; ++f)
    hull.radius = -height[f] < hull.radius ? -height[f] : hull.radius;
}

struct SignMasks {
  unsigned may_rise[16], may_fall[16];  // a face's, bit e: edge e of the other along or against the normal
};

template <class Pack>
TOUCHSTONE_INLINE void find_signs(const PosedHull& faces, const PosedHull& edges, SignMasks& out) {
  const Pack tolerance = all<Pack>(kUncertainSign);
  for (int f = 0; f < faces.hull->face_count; ++f) {
    const Vector3Of<Pack> n = {all<Pack>(faces.nx[f]), all<Pack>(faces.ny[f]), all<Pack>(faces.nz[f])};
    unsigned rise = 0, fall = 0;
    for (int e = 0; e < edges.hull->edge_count; e += Traits<Pack>::lanes) {
      const Pack along = dot(
          n, Vector3Of<Pack>{load<Pack>(edges.ex + e), load<Pack>(edges.ey + e), load<Pack>(edges.ez + e)});
      rise |= bits(along > -tolerance) << e;
      fall |= bits(along < tolerance) << e;
    }
    out.may_rise[f] = rise, out.may_fall[f] = fall;
  }
}

/// Bit e: some face beside edge e has the other's middle no deeper below it than `depth`, to rounding.
TOUCHSTONE_INLINE unsigned edges_in_question(const PosedHull& hull, const double (&below)[16], double depth,
                                             const Magnitudes& size) {
  const double least = (depth > 0.0 ? depth : 0.0) + size.rounding(kPruneRoundoffs);
  unsigned out = 0;
  for (int f = 0; f < hull.hull->face_count; ++f) {
    const unsigned near = below[f] > least ? 0u : ~0u;
    out |= hull.hull->face_edges[f] & near;
  }
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE void projections(const double* v, Point n, double (&out)[8]) {
  for (int i = 0; i < 8; i += Traits<Pack>::lanes)
    store(dot(Vector3Of<Pack>{all<Pack>(n.x), all<Pack>(n.y), all<Pack>(n.z)},
              Vector3Of<Pack>{load<Pack>(v + i), load<Pack>(v + 8 + i), load<Pack>(v + 16 + i)}),
          out + i);
}

/// The hulls' separation along n.
template <class Pack>
TOUCHSTONE_INLINE double hull_separation(const PosedHull& A, const PosedHull& B, Point n) {
  double a[8], b[8];
  projections<Pack>(A.vertices, n, a);
  projections<Pack>(B.vertices, n, b);
  double high = a[0], low = b[0];
  for (int i = 1; i < 8; ++i) high = a[i] > high ? a[i] : high, low = b[i] < low ? b[i] : low;
  return low - high;
}

struct HullAxis {
  double separation;
  Point n;
  int face_a = -1, face_b = -1;  // else the edges
  int edge_a = -1, edge_b = -1;
};

enum class EdgeSearch : unsigned char { done, too_parallel };

template <class Pack>
TOUCHSTONE_INLINE EdgeSearch try_edges(const PosedHull& A, int i, const PosedHull& B, int j, double sign,
                                       double extent, HullAxis& best) {
  const Point c = sign * cross(A.edge(i), B.edge(j));
  const double length2 = dot(c, c);
  const Point w = B.vertex(B.hull->edge_vertices[j][0]) - A.vertex(A.hull->edge_vertices[i][0]);
  const double overlap = -dot(c, w) - kEdgeRoundoffs * kU * extent;
  if (overlap > 0.0 && overlap * overlap > (best.separation * best.separation) * length2)
    return EdgeSearch::done;
  if (!(length2 > kNoCross2)) return EdgeSearch::done;
  if (length2 < kShortCross2) return EdgeSearch::too_parallel;
  const Point n = (1.0 / __builtin_sqrt(length2)) * c;
  const double separation = hull_separation<Pack>(A, B, n);
  if (separation > best.separation + kTieOfExtent * kU * extent) {
    best = {separation, n};
    best.edge_a = i, best.edge_b = j;
  }
  return EdgeSearch::done;
}

template <class Pack>
TOUCHSTONE_INLINE EdgeSearch search_edges(const PosedHull& A, unsigned edges_a, const PosedHull& B,
                                          unsigned edges_b, double extent, HullAxis& best) {
  SignMasks of_a, of_b;  // of A's faces against B's edges, of B's faces against A's edges
  find_signs<Pack>(A, B, of_a);
  find_signs<Pack>(B, A, of_b);
  for (unsigned rest = edges_a; rest != 0; rest &= rest - 1) {
    const int i = __builtin_ctz(rest);
    const int u1 = A.hull->edge_faces[i][0], u2 = A.hull->edge_faces[i][1];
    for (int turned = 0; turned < 2; ++turned) {
      unsigned crossing =
          edges_b & (turned ? of_a.may_fall[u1] & of_a.may_rise[u2] : of_a.may_rise[u1] & of_a.may_fall[u2]);
      for (; crossing != 0; crossing &= crossing - 1) {
        const int j = __builtin_ctz(crossing);
        const int w1 = B.hull->edge_faces[j][0], w2 = B.hull->edge_faces[j][1];
        const unsigned arcs =
            turned ? of_b.may_fall[w1] & of_b.may_rise[w2] : of_b.may_rise[w1] & of_b.may_fall[w2];
        if (!(arcs >> i & 1u)) continue;
        if (try_edges<Pack>(A, i, B, j, turned ? -1.0 : 1.0, extent, best) == EdgeSearch::too_parallel)
          return EdgeSearch::too_parallel;
      }
    }
  }
  return EdgeSearch::done;
}

// ---- Witness points

/// On the face. Where corners are sharp a point near all planes may be far from the hull. But one that lies e
/// beyond them, at a distance d from the middle of a ball of radius r within, is no further than e d / r from
/// it: moved to the middle by the factor r / (r + e) it is within.
template <class Pack>
TOUCHSTONE_INLINE bool is_on_face(const PosedHull& hull, int face, Point p, const Magnitudes& size) {
  double height[16];
  heights_over<Pack>(hull, p, height);
  const double over = dot(hull.normal(face), p) - hull.height[face], off = over < 0.0 ? -over : over;
  double beyond = -__builtin_inf();
  for (int f = 0; f < hull.hull->face_count; ++f)
    beyond = f != face && height[f] > beyond ? height[f] : beyond;
  if (!(off <= kHullWitnessRoundoffs * kU * size.extent)) return false;
  beyond = beyond + off + size.rounding(kHeightRoundoffs);  // of p moved onto the face's plane
  if (beyond <= 0.0) return true;
  const Point d = p - hull.middle;
  return beyond * __builtin_sqrt(dot(d, d)) <= kOffHullRoundoffs * kU * size.position * hull.radius;
}

/// The point of `other` that lies over `base`'s face: the vertex furthest along `direction`, or the mean of
/// those level with it. `offset` leads from it to `base`'s surface.
template <class Pack>
TOUCHSTONE_INLINE bool face_witness(const PosedHull& base, int face, const PosedHull& other, Point direction,
                                    Point offset, const Magnitudes& size, Point& p) {
  const double level = 4 * kU * size.extent;
  double along[8];
  projections<Pack>(other.vertices, direction, along);
  double high = along[0];
  for (int i = 1; i < 8; ++i) high = along[i] > high ? along[i] : high;
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
  const auto &of_a = A.hull->edge_vertices[axis.edge_a], &of_b = B.hull->edge_vertices[axis.edge_b];
  const Point a0 = A.vertex(of_a[0]), b0 = B.vertex(of_b[0]);
  const Point a = A.vertex(of_a[1]) - a0, b = B.vertex(of_b[1]) - b0;
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

template <class Pack>
TOUCHSTONE_INLINE void compute_hull_depth_inline(const HullView& a, const HullView& b, double extent,
                                                 double position, DepthRecord& out) {
  out.certified = Certified::unknown;
  out.known = DepthKnown::nothing;
  PosedHull A, B;
  pose_hull<Pack>(a, A), pose_hull<Pack>(b, B);
  // The best face of either.
  double separation_a[16], separation_b[16], below_a[16], below_b[16];
  find_middle<Pack>(A), find_middle<Pack>(B);
  face_separations<Pack>(A, B, B.middle, separation_a, below_a);
  face_separations<Pack>(B, A, A.middle, separation_b, below_b);
  HullAxis best{-__builtin_inf(), {}};
  for (int f = 0; f < A.hull->face_count; ++f)
    if (separation_a[f] > best.separation) best.separation = separation_a[f], best.face_a = f;
  for (int f = 0; f < B.hull->face_count; ++f) {
    if (separation_b[f] > best.separation + kTieOfExtent * kU * extent)
      best.separation = separation_b[f], best.face_a = -1, best.face_b = f;
  }
  best.n = best.face_a >= 0 ? A.normal(best.face_a) : -1.0 * B.normal(best.face_b);
  best.separation = hull_separation<Pack>(A, B, best.n);
  const Magnitudes size = {extent, position};
  const double margin = size.rounding(kHullRoundoffs);
  if (best.separation > margin) {
    out.certified = Certified::separated;
    return;
  }
  // Edges that could do better.
  const unsigned edges_a = edges_in_question(A, below_a, -best.separation - B.radius, size);
  const unsigned edges_b = edges_in_question(B, below_b, -best.separation - A.radius, size);
  if (search_edges<Pack>(A, edges_a, B, edges_b, extent, best) == EdgeSearch::too_parallel) return;
  if (best.separation > margin) {
    out.certified = Certified::separated;
    return;
  }
  // Verdict, depth and witness.
  if (best.separation < -margin) out.certified = Certified::overlapping;
  best.separation = best.separation < 0.0 ? best.separation : 0.0;
  Point p_A{};
  out.known = find_witness<Pack>(A, B, best, size, p_A) ? DepthKnown::witness : DepthKnown::axis;
  out.separation = best.separation;
  out.n[0] = best.n.x, out.n[1] = best.n.y, out.n[2] = best.n.z;
  out.p_A[0] = p_A.x, out.p_A[1] = p_A.y, out.p_A[2] = p_A.z;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
