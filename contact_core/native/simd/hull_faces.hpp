#pragma once

#include "touchstone/contact_core/native/simd/pair_blocks.hpp"

// One pair of hexahedra in the world: their faces, and how far each lies beyond the other's.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kHullPositionRoundoffs = 8.0;
constexpr double kTieOfExtent = 2.0;

using Point = Vector3Of<double>;

/// See compute_hull_depth.
struct Magnitudes {
  double extent, position;

  /// `of_extent` u of the extent, and the world vertices' rounding.
  TOUCHSTONE_INLINE double rounding(double of_extent) const {
    return of_extent * kU * extent + kHullPositionRoundoffs * kU * position;
  }
};

/// A solid's faces in the world.
struct PosedHull {
  static constexpr int kMostFaces = 16;  // as lanes are filled

  const HullRecord* hull;
  const double* vertices;  // x of eight, y of eight, z of eight
  const double* R;
  alignas(64) double nx[kMostFaces], ny[kMostFaces], nz[kMostFaces];
  alignas(64) double height[kMostFaces] = {};

  TOUCHSTONE_INLINE Point vertex(int i) const { return {vertices[i], vertices[8 + i], vertices[16 + i]}; }
  TOUCHSTONE_INLINE Point normal(int f) const { return {nx[f], ny[f], nz[f]}; }
};

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> broadcast(const Point& p) {
  return {all<Pack>(p.x), all<Pack>(p.y), all<Pack>(p.z)};
}

/// The greatest, the least of the lanes.
TOUCHSTONE_INLINE double greatest_lane(Double2 p) { return p[0] > p[1] ? p[0] : p[1]; }
TOUCHSTONE_INLINE double greatest_lane(Double4 p) {
  return greatest_lane(greatest(__builtin_shufflevector(p, p, 0, 1), __builtin_shufflevector(p, p, 2, 3)));
}
TOUCHSTONE_INLINE double least_lane(Double2 p) { return p[0] < p[1] ? p[0] : p[1]; }
TOUCHSTONE_INLINE double least_lane(Double4 p) {
  return least_lane(least(__builtin_shufflevector(p, p, 0, 1), __builtin_shufflevector(p, p, 2, 3)));
}

/// Lane l: the least lane of row l.
TOUCHSTONE_INLINE Double2 least_lanes(const Double2 (&rows)[2]) {
  return least(__builtin_shufflevector(rows[0], rows[1], 0, 2),
               __builtin_shufflevector(rows[0], rows[1], 1, 3));
}
TOUCHSTONE_INLINE Double4 least_lanes(const Double4 (&rows)[4]) {
  const auto of_two = [&](int i) {  // 0 1 0 1
    return least(__builtin_shufflevector(rows[i], rows[i + 1], 0, 4, 2, 6),
                 __builtin_shufflevector(rows[i], rows[i + 1], 1, 5, 3, 7));
  };
  const Double4 p = of_two(0), q = of_two(2);
  return least(__builtin_shufflevector(p, q, 0, 1, 4, 5), __builtin_shufflevector(p, q, 2, 3, 6, 7));
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> rotated(const double* R, const Vector3Of<Pack>& p) {
  return {(all<Pack>(R[0]) * p.x + all<Pack>(R[3]) * p.y) + all<Pack>(R[6]) * p.z,
          (all<Pack>(R[1]) * p.x + all<Pack>(R[4]) * p.y) + all<Pack>(R[7]) * p.z,
          (all<Pack>(R[2]) * p.x + all<Pack>(R[5]) * p.y) + all<Pack>(R[8]) * p.z};
}

template <class Pack>
TOUCHSTONE_INLINE void pose_faces(const HullView& view, PosedHull& out) {
  const HullRecord& hull = *view.hull;
  out.hull = &hull, out.vertices = view.vertices, out.R = view.R;
  const double* R = view.R;
  double N[9];
  for (int i = 0; i < 3; ++i) {
    const double *p = R + 3 * ((i + 1) % 3), *q = R + 3 * ((i + 2) % 3);
    const Point c = cross(Point{p[0], p[1], p[2]}, Point{q[0], q[1], q[2]});
    N[3 * i] = c.x, N[3 * i + 1] = c.y, N[3 * i + 2] = c.z;
  }
  for (int f = 0; f < hull.face_count; f += Traits<Pack>::lanes) {
    const HullRecord::Normals& normals = hull.normals[f / 8];
    const Vector3Of<Pack> local = {load<Pack>(normals.x + f % 8), load<Pack>(normals.y + f % 8),
                                   load<Pack>(normals.z + f % 8)};
    Vector3Of<Pack> n = rotated<Pack>(N, local);
    n = (all<Pack>(1.0) / square_root(dot(n, n))) * n;
    store(n.x, out.nx + f), store(n.y, out.ny + f), store(n.z, out.nz + f);
  }
  for (int f = 0; f < hull.face_count; ++f)
    out.height[f] = dot(out.normal(f), out.vertex(hull.face_vertex[f]));
}

/// Eight vertices along an axis, and the least or greatest of two of these in each lane.
template <class Pack>
struct Projections {
  static constexpr int kPacks = 8 / Traits<Pack>::lanes;

  Pack along[kPacks];

  TOUCHSTONE_INLINE Projections(const double* v, const Point& n) {
    const Vector3Of<Pack> axis = broadcast<Pack>(n);
    for (int k = 0; k < kPacks; ++k) {
      const double* const from = v + k * Traits<Pack>::lanes;
      along[k] = dot(axis, Vector3Of<Pack>{load<Pack>(from), load<Pack>(from + 8), load<Pack>(from + 16)});
    }
  }
  TOUCHSTONE_INLINE Pack least_lanes() const {
    Pack out = along[0];
    for (int k = 1; k < kPacks; ++k) out = least(along[k], out);
    return out;
  }
  TOUCHSTONE_INLINE double lowest() const { return least_lane(least_lanes()); }
  TOUCHSTONE_INLINE double highest() const {
    Pack out = along[0];
    for (int k = 1; k < kPacks; ++k) out = greatest(along[k], out);
    return greatest_lane(out);
  }
  /// The first vertex that has `value`, one of the eight's.
  TOUCHSTONE_INLINE int first_at(double value) const {
    unsigned equal = 0x80;
    for (int k = 0; k < kPacks; ++k) equal |= bits(along[k] == all<Pack>(value)) << k * Traits<Pack>::lanes;
    return __builtin_ctz(equal);
  }
  TOUCHSTONE_INLINE void write(double (&out)[8]) const {
    for (int k = 0; k < kPacks; ++k) store(along[k], out + k * Traits<Pack>::lanes);
  }
};

/// The other solid as seen from each face.
struct FaceDepths {
  alignas(64) double along[PosedHull::kMostFaces][8];    // normal . vertex, of the other's
  alignas(64) double low[PosedHull::kMostFaces];         // the least of these
  alignas(64) double separation[PosedHull::kMostFaces];  // negative: inside; -inf beyond the last
};

/// Lanes whose number, from `first` on, is below `count`.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> lanes_below(int first, int count) {
  static constexpr double kNumbers[4] = {0.0, 1.0, 2.0, 3.0};
  return load<Pack>(kNumbers) < all<Pack>(count - first);
}

template <class Pack>
TOUCHSTONE_INLINE void find_face_depths(const PosedHull& base, const PosedHull& other, FaceDepths& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const int count = base.hull->face_count;
  int first = 0;
  do {
    Pack rows[kLanes] = {};
    for (int f = first, l = 0; l < kLanes && f < count; ++f, ++l) {
      const Projections<Pack> vertices(other.vertices, base.normal(f));
      vertices.write(out.along[f]);
      rows[l] = vertices.least_lanes();
    }
    const Pack low = least_lanes(rows), separation = low - load<Pack>(base.height + first);
    store(low, out.low + first);
    store(select(lanes_below<Pack>(first, count), separation, all<Pack>(-__builtin_inf())),
          out.separation + first);
    first += kLanes;
  } while (first < count);
}

/// How far p lies outside the face of those it is furthest outside of, `but` left out.
template <class Pack>
TOUCHSTONE_INLINE double highest_over(const PosedHull& hull, Point p, int but) {
  double height[PosedHull::kMostFaces];
  for (int f = 0; f < hull.hull->face_count; f += Traits<Pack>::lanes)
    store(dot(Vector3Of<Pack>{load<Pack>(hull.nx + f), load<Pack>(hull.ny + f), load<Pack>(hull.nz + f)},
              broadcast<Pack>(p)) -
              load<Pack>(hull.height + f),
          height + f);
  double highest = -__builtin_inf();
  for (int f = 0; f < hull.hull->face_count; ++f)
    highest = f != but && height[f] > highest ? height[f] : highest;
  return highest;
}

// ---- Both hulls along an axis

/// The hulls' separation along n.
template <class Pack>
TOUCHSTONE_INLINE double hull_separation(const PosedHull& A, const PosedHull& B, Point n) {
  return Projections<Pack>(B.vertices, n).lowest() - Projections<Pack>(A.vertices, n).highest();
}

struct HullAxis {
  double separation;
  Point n;
  int face_a = -1, face_b = -1;  // else the edges
  int edge_a = -1, edge_b = -1;
};

/// Bit f: separation f less than `tie` below `value`.
template <class Pack>
TOUCHSTONE_INLINE unsigned as_good(const FaceDepths& depths, int count, double tie, double value) {
  unsigned out = 0;
  for (int f = 0; f < count; f += Traits<Pack>::lanes)
    out |= bits(load<Pack>(depths.separation + f) + all<Pack>(tie) >= all<Pack>(value)) << f;
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE double greatest_separation(const FaceDepths& depths, int count) {
  Pack high = load<Pack>(depths.separation);
  for (int f = Traits<Pack>::lanes; f < count; f += Traits<Pack>::lanes)
    high = greatest(load<Pack>(depths.separation + f), high);
  return greatest_lane(high);
}

/// The first of B's faces that is better than all before it, and than A's best, by more than rounding; -1
/// where none is.
template <class Pack>
TOUCHSTONE_INLINE int better_face(const FaceDepths& of_b, int count, double tie, double separation) {
  const double best = greatest_separation<Pack>(of_b, count);
  if (!(best > separation + tie)) return -1;
  const unsigned good = as_good<Pack>(of_b, count, tie, best);
  if (__builtin_expect((good & (good - 1)) == 0, 1)) return __builtin_ctz(good);
  int face = -1;
  for (int f = 0; f < count; ++f)
    if (of_b.separation[f] > separation + tie) separation = of_b.separation[f], face = f;
  return face;
}

/// Of the faces of either the one with the greatest separation: the first, but one of B must be better by
/// more than rounding.
template <class Pack>
TOUCHSTONE_INLINE HullAxis best_face(const PosedHull& A, const FaceDepths& of_a, const PosedHull& B,
                                     const FaceDepths& of_b, double extent) {
  const int count_a = A.hull->face_count, count_b = B.hull->face_count;
  const double on_a = greatest_separation<Pack>(of_a, count_a);
  HullAxis best{on_a, {}};
  best.face_a = __builtin_ctz(as_good<Pack>(of_a, count_a, 0.0, on_a));
  best.face_b = better_face<Pack>(of_b, count_b, kTieOfExtent * kU * extent, on_a);
  const bool is_b = best.face_b >= 0;
  const PosedHull& base = is_b ? B : A;
  const FaceDepths& depths = is_b ? of_b : of_a;
  const int face = is_b ? best.face_b : best.face_a;
  if (is_b) best.face_a = -1;
  // hull_separation() along that normal, half of which is known.
  const Point n = base.normal(face);
  best.separation = depths.low[face] - Projections<Pack>(base.vertices, n).highest();
  best.n = is_b ? -1.0 * n : n;
  return best;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
