#pragma once

#include "touchstone/contact_core/native/simd/pair_blocks.hpp"

// One pair of hexahedra in the world: their faces, and how far each lies beyond the other's.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kHullPositionRoundoffs = 8.0;
constexpr double kTieOfExtent = 2.0;
/// Normals are as long as this: no length that is compared is off by more than 8 u of itself.
constexpr double kUnitSquareRoundoffs = 16.0;

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

  const HullTopology* hull;
  const double* vertices;  // x of eight, y of eight, z of eight
  alignas(64) double nx[kMostFaces], ny[kMostFaces], nz[kMostFaces];
  alignas(64) double height[kMostFaces];

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
TOUCHSTONE_INLINE double greatest_lane(Double8 p) {
  return greatest_lane(
      greatest(__builtin_shufflevector(p, p, 0, 1, 2, 3), __builtin_shufflevector(p, p, 4, 5, 6, 7)));
}
TOUCHSTONE_INLINE double least_lane(Double2 p) { return p[0] < p[1] ? p[0] : p[1]; }
TOUCHSTONE_INLINE double least_lane(Double4 p) {
  return least_lane(least(__builtin_shufflevector(p, p, 0, 1), __builtin_shufflevector(p, p, 2, 3)));
}
TOUCHSTONE_INLINE double least_lane(Double8 p) {
  return least_lane(
      least(__builtin_shufflevector(p, p, 0, 1, 2, 3), __builtin_shufflevector(p, p, 4, 5, 6, 7)));
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

TOUCHSTONE_INLINE Double8 least_lanes(const Double8 (&rows)[8]) {
  const auto of_two = [&](int i) {  // 0 1 0 1 0 1 0 1
    return least(__builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 2, 10, 4, 12, 6, 14),
                 __builtin_shufflevector(rows[i], rows[i + 1], 1, 9, 3, 11, 5, 13, 7, 15));
  };
  const auto of_four = [&](int i) {  // 0 1 2 3 0 1 2 3
    const Double8 p = of_two(i), q = of_two(i + 2);
    return least(__builtin_shufflevector(p, q, 0, 1, 8, 9, 4, 5, 12, 13),
                 __builtin_shufflevector(p, q, 2, 3, 10, 11, 6, 7, 14, 15));
  };
  const Double8 p = of_four(0), q = of_four(4);
  return least(__builtin_shufflevector(p, q, 0, 1, 2, 3, 8, 9, 10, 11),
               __builtin_shufflevector(p, q, 4, 5, 6, 7, 12, 13, 14, 15));
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> rotated(const double* R, const Vector3Of<Pack>& p) {
  return {(all<Pack>(R[0]) * p.x + all<Pack>(R[3]) * p.y) + all<Pack>(R[6]) * p.z,
          (all<Pack>(R[1]) * p.x + all<Pack>(R[4]) * p.y) + all<Pack>(R[7]) * p.z,
          (all<Pack>(R[2]) * p.x + all<Pack>(R[5]) * p.y) + all<Pack>(R[8]) * p.z};
}

/// Lanes whose number, from `first` on, is below `count`.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> lanes_below(int first, int count) {
  static constexpr double kNumbers[8] = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  return load<Pack>(kNumbers) < all<Pack>(count - first);
}

/// Eight places in a list of eight vertices, or of sixteen faces, a byte each.
using PlaceWord = std::uint64_t;

TOUCHSTONE_INLINE PlaceWord places_at(const std::uint8_t* from) {
  PlaceWord out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}

/// Lane l: from[byte l], of eight or of sixteen numbers.
TOUCHSTONE_INLINE Double2 picked(const double* from, PlaceWord w, Double2) {
  return Double2{from[w & 0xff], from[w >> 8 & 0xff]};
}
TOUCHSTONE_INLINE Double4 picked(const double* from, PlaceWord w, Double4) {
  return Double4{from[w & 0xff], from[w >> 8 & 0xff], from[w >> 16 & 0xff], from[w >> 24 & 0xff]};
}
#if defined(__AVX512F__)
TOUCHSTONE_INLINE __m512i lanes_of_bytes(PlaceWord w) {
  return _mm512_maskz_cvtepu8_epi64(0xff, _mm_cvtsi64_si128(static_cast<long long>(w)));
}
TOUCHSTONE_INLINE Double8 picked(const double* from, PlaceWord w, Double8) {
  return (Double8)_mm512_maskz_permutexvar_pd(0xff, lanes_of_bytes(w), (__m512d)load<Double8>(from));
}
TOUCHSTONE_INLINE Double8 picked_of_sixteen(const double* from, PlaceWord w, Double8) {
  return (Double8)_mm512_permutex2var_pd((__m512d)load<Double8>(from), lanes_of_bytes(w),
                                         (__m512d)load<Double8>(from + 8));
}
#endif
template <class Pack>
TOUCHSTONE_INLINE Pack picked_of_sixteen(const double* from, PlaceWord w, Pack) {
  return picked(from, w, Pack{});
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> picked_vertices(const PosedHull& hull, PlaceWord w) {
  const double* const v = hull.vertices;
  return {picked(v, w, Pack{}), picked(v + 8, w, Pack{}), picked(v + 16, w, Pack{})};
}
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> picked_normals(const PosedHull& hull, PlaceWord w) {
  return {picked_of_sixteen(hull.nx, w, Pack{}), picked_of_sixteen(hull.ny, w, Pack{}),
          picked_of_sixteen(hull.nz, w, Pack{})};
}

/// Where the faces' normals are: x of all, y, z.
struct NormalsView {
  const double* of_axis[3];

  template <class Pack>
  TOUCHSTONE_INLINE Vector3Of<Pack> at(int first) const {
    return {load<Pack>(of_axis[0] + first), load<Pack>(of_axis[1] + first), load<Pack>(of_axis[2] + first)};
  }
};

/// cofactor(R), by columns as R.
struct Cofactors {
  double of[9];

  TOUCHSTONE_INLINE explicit Cofactors(const double* R) {
    for (int i = 0; i < 3; ++i) {
      const double *p = R + 3 * ((i + 1) % 3), *q = R + 3 * ((i + 2) % 3);
      const Point c = cross(Point{p[0], p[1], p[2]}, Point{q[0], q[1], q[2]});
      of[3 * i] = c.x, of[3 * i + 1] = c.y, of[3 * i + 2] = c.z;
    }
  }
};

/// Normals and heights of at most eight faces, `first` on. @param hull of the pair's, with `count` faces
template <class Pack>
TOUCHSTONE_INLINE void pose_eight_faces(const HullTopology& hull, int count, int first,
                                        const NormalsView& local, const Cofactors& N, PosedHull& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  MaskOf<Pack> is_off{};  // poses may be no rotations by up to kRotationTolerance
  for (int f = 0; f < 8 && first + f < count; f += kLanes) {
    const Vector3Of<Pack> n = rotated<Pack>(N.of, local.at<Pack>(f));
    is_off |= (magnitude(dot(n, n) - all<Pack>(1.0)) > all<Pack>(kUnitSquareRoundoffs * kU)) &
              lanes_below<Pack>(first + f, count);
    store(n.x, out.nx + first + f), store(n.y, out.ny + first + f), store(n.z, out.nz + first + f);
  }
  const bool are_off = bits(is_off) != 0;
  for (int f = first; f < first + 8 && f < count; f += kLanes) {
    Vector3Of<Pack> n = {load<Pack>(out.nx + f), load<Pack>(out.ny + f), load<Pack>(out.nz + f)};
    if (__builtin_expect(are_off, 0)) {
      n = (all<Pack>(1.0) / square_root(dot(n, n))) * n;
      store(n.x, out.nx + f), store(n.y, out.ny + f), store(n.z, out.nz + f);
    }
    store(dot(n, picked_vertices<Pack>(out, places_at(hull.face_vertex + f))), out.height + f);
  }
}

template <class Pack>
TOUCHSTONE_INLINE void pose_faces(const HullView& view, PosedHull& out) {
  const HullTopology& hull = view.hull->topology;
  out.hull = &hull, out.vertices = view.vertices;
  const Cofactors N(view.R);
  for (int first = 0; first < hull.face_count; first += 8) {
    const HullRecord::Normals& normals = view.hull->normals[first / 8];
    pose_eight_faces<Pack>(hull, hull.face_count, first, {{normals.x, normals.y, normals.z}}, N, out);
  }
}

/// The same of a regular hull: `out` has its vertices.
template <class Pack>
TOUCHSTONE_INLINE void pose_faces(const PlainHull& hull, const double* R, PosedHull& out) {
  static_assert(__builtin_offsetof(PlainHull, padding) == 3 * kRegularFaces * sizeof(double));
  out.hull = &kRegularHull;
  pose_eight_faces<Pack>(kRegularHull, kRegularFaces, 0,
                         {{hull.normals[0], hull.normals[1], hull.normals[2]}}, Cofactors(R), out);
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

template <class Pack>
TOUCHSTONE_INLINE void find_face_depths(const PosedHull& base, int count, const PosedHull& other,
                                        FaceDepths& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  int first = 0;
  do {
    Pack rows[kLanes];
    int l = 0;
    do {
      const Projections<Pack> vertices(other.vertices, base.normal(first + l));
      vertices.write(out.along[first + l]);
      rows[l++] = vertices.least_lanes();
    } while (l < kLanes && first + l < count);
    while (l < kLanes) rows[l++] = rows[0];  // zeros would cost a `rep stos` by g++
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

/// Bit f: separation f is at least `value`.
template <class Pack>
TOUCHSTONE_INLINE unsigned as_good(const FaceDepths& depths, int count, double value) {
  unsigned out = 0;
  for (int f = 0; f < count; f += Traits<Pack>::lanes)
    out |= bits(load<Pack>(depths.separation + f) >= all<Pack>(value)) << f;
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE double greatest_separation(const FaceDepths& depths, int count) {
  Pack high = load<Pack>(depths.separation);
  for (int f = Traits<Pack>::lanes; f < count; f += Traits<Pack>::lanes)
    high = greatest(load<Pack>(depths.separation + f), high);
  return greatest_lane(high);
}

/// Of the faces of either the one with the greatest separation: the first, but one of B must be better by
/// more than rounding.
struct FaceChoice {
  double separation, low;  ///< as the normal's length has it; the least normal . vertex of the other's
  int face;
  bool is_b;
};

/// Without a branch, whose outcome no predictor could guess and which would wait for all before it.
template <class Pack>
TOUCHSTONE_INLINE FaceChoice choose_face(const FaceDepths (&depths)[2], int count_a, int count_b,
                                         double extent) {
  const double best[2] = {greatest_separation<Pack>(depths[0], count_a),
                          greatest_separation<Pack>(depths[1], count_b)};
  const unsigned good[2] = {as_good<Pack>(depths[0], count_a, best[0]),
                            as_good<Pack>(depths[1], count_b, best[1])};
  FaceChoice out;
  out.is_b = best[1] > best[0] + kTieOfExtent * kU * extent;
  out.face = __builtin_ctz(good[out.is_b] | 1u << 15);
  out.separation = best[out.is_b], out.low = depths[out.is_b].low[out.face];
  return out;
}

/// The axis of that face: hull_separation() along its unit normal, half of which is known.
template <class Pack>
TOUCHSTONE_INLINE HullAxis axis_of(const FaceChoice& choice, const PosedHull& A, const PosedHull& B) {
  const PosedHull& base = choice.is_b ? B : A;
  const Point normal = base.normal(choice.face);
  const double scale = 1.0 / __builtin_sqrt(dot(normal, normal));
  const Point n = scale * normal;
  HullAxis out{scale * choice.low - Projections<Pack>(base.vertices, n).highest(),
               choice.is_b ? -1.0 * n : n};
  (choice.is_b ? out.face_b : out.face_a) = choice.face;
  return out;
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
