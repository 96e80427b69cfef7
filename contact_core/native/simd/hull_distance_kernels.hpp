#pragma once

#include "touchstone/contact_core/native/simd/distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/hull_faces.hpp"
#include "touchstone/contact_core/native/simd/mpr_kernels.hpp"

// The distance of any two separated hulls of eight vertices, pairs in lanes: Gilbert, Johnson and
// Keerthi's search (gjk.hpp) without a branch.
//
// W = B - A. A triangle s of W's vertices, some of which may be the same, carries the point v of W nearest
// the origin so far; the vertex w of W furthest along -v joins it. As v was the nearest point of s and w lies
// nearer, the nearest point of the tetrahedron is on a face, an edge or a corner that has w: seven
// candidates. Each is given by cross products of w and the edges e_i = s_i - w, free of cancellation: |w|^2,
// |w x e_i|^2 / |e_i|^2, (w . n)^2 / |n|^2 with n = e_i x e_j. The least one whose foot lies inside it is
// taken; of s stay the corners it has, w takes the places of the others.
//
// The search is not trusted: its result is verified on the vertices about the pair's common
// origin (shift_to_common_origin) and so by the bounds of separated_distance(). With v across s the following
// must agree to 16 u * extent: |v|, the point of W that the weights of s name, and the projections'
// separation along n = v / |v|, the first two bounds of the distance from above and the third from below.
// Short v, whose direction rounding turns, slivers, and pairs that seem to overlap are left to scalar code.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Of 4096 random frusta apart no pair needs more than 12.
constexpr int kSearchSteps = 16;
constexpr double kSearchRoundoffs = 2.0;
/// projection_error() of a unit axis: |n|_1 < 2.
constexpr double kDistanceRoundoffs = 24.0;

template <class Lanes>
struct HullLanes {
  using Pack = Lanes;

  VertexLanes<Pack> a, b;  // about A's first vertex
  Vector3Of<Pack> origin;  // that vertex, from A's origin, in world axes
  Pack extent;             // at least every |coordinate| of a and b
  MaskOf<Pack> ordinary;
};

/// The same of one pair, its vertices in lanes.
struct OneHullPair {
  using Pack = Double2;

  double a[24], b[24];  // x of eight, y of eight, z of eight
  Vector3Of<Pack> origin;
  Pack extent;
  MaskOf<Pack> ordinary;
};

/// A vertex of W and A's part in it.
template <class Pack>
struct Corner {
  Vector3Of<Pack> w, a;
};

template <class Pack>
struct Search {
  Corner<Pack> s[3];
  Vector3Of<Pack> v;
  Pack square;  // |v|^2
};

// ---- The vertices, with the bits of world_vertices() and shift_to_common_origin()

template <class Pack>
TOUCHSTONE_INLINE void shift(const Vector3Of<Pack>& origin, VertexLanes<Pack>& v, Pack& extent) {
  for (int i = 0; i < 8; ++i) {
    v.x[i] = v.x[i] - origin.x, v.y[i] = v.y[i] - origin.y, v.z[i] = v.z[i] - origin.z;
    extent = greatest(extent, largest(Vector3Of<Pack>{v.x[i], v.y[i], v.z[i]}));
  }
}

template <class Pack>
TOUCHSTONE_INLINE void gather_hulls(const double* const (&poses_a)[Traits<Pack>::lanes],
                                    const double* const (&shapes_a)[Traits<Pack>::lanes],
                                    const double* const (&poses_b)[Traits<Pack>::lanes],
                                    const double* const (&shapes_b)[Traits<Pack>::lanes],
                                    HullLanes<Pack>& out) {
  const PoseLanes<Pack> X_WA = gather_poses<Pack>(poses_a), X_WB = gather_poses<Pack>(poses_b);
  Pack reach{};
  place_vertices<Pack>(shapes_a, X_WA, &X_WA.p, reach, out.a);
  place_vertices<Pack>(shapes_b, X_WB, &X_WB.p, reach, out.b);
  const Vector3Of<Pack> first = {out.a.x[0], out.a.y[0], out.a.z[0]};
  out.origin = first - X_WA.p;
  out.extent = Pack{};
  shift(first, out.a, out.extent);
  shift(first, out.b, out.extent);
  out.ordinary = (reach < all<Pack>(kDistanceHigh)) & (out.extent > all<Pack>(kDistanceLow));
}

/// Least axis . w over W's vertices, and where it is.
template <class Pack>
TOUCHSTONE_INLINE Pack least_along(const HullLanes<Pack>& pair, const Vector3Of<Pack>& axis,
                                   Corner<Pack>& corner) {
  const Vector3Of<Pack> back = {-axis.x, -axis.y, -axis.z};
  Pack on_a, on_b;
  corner.a = highest(pair.a, axis, on_a);
  corner.w = highest(pair.b, back, on_b) - corner.a;
  return -(on_b + on_a);
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> vertex_of(const VertexLanes<Pack>& v, int i) {
  return {v.x[i], v.y[i], v.z[i]};
}

template <class Pack>
TOUCHSTONE_INLINE Pack separation_along(const HullLanes<Pack>& pair, const Vector3Of<Pack>& n) {
  const auto along = [&n](const VertexLanes<Pack>& v, int i) {
    return (n.x * v.x[i] + n.y * v.y[i]) + n.z * v.z[i];
  };
  Pack high = along(pair.a, 0), low = along(pair.b, 0);
  for (int i = 1; i < 8; ++i) {
    high = greatest(high, along(pair.a, i));
    low = least(low, along(pair.b, i));
  }
  return low - high;
}

// ---- The same of one pair

TOUCHSTONE_INLINE Vector3Of<Double2> vertex_of(const double (&v)[24], int i) {
  return broadcast<Double2>(Point{v[i], v[8 + i], v[16 + i]});
}

/// R v + p of eight vertices; the largest magnitude joins `reach`.
template <class Wide>
TOUCHSTONE_INLINE void place_vertices(const PoseRecord& X, const VertexRecord& from, Wide& reach,
                                      double (&out)[24]) {
  for (int i = 0; i < 8; i += Traits<Wide>::lanes) {
    const Vector3Of<Wide> local = {load<Wide>(from.x + i), load<Wide>(from.y + i), load<Wide>(from.z + i)};
    const Vector3Of<Wide> v = rotated<Wide>(X.R, local) + broadcast<Wide>(Point{X.p[0], X.p[1], X.p[2]});
    store(v.x, out + i), store(v.y, out + 8 + i), store(v.z, out + 16 + i);
    reach = greatest(reach, largest(v));
  }
}

template <class Wide>
TOUCHSTONE_INLINE void shift(const Point& origin, double (&v)[24], Wide& extent) {
  const double of_axis[3] = {origin.x, origin.y, origin.z};
  for (int i = 0; i < 24; i += Traits<Wide>::lanes) {
    const Wide shifted = load<Wide>(v + i) - all<Wide>(of_axis[i / 8]);
    store(shifted, v + i);
    extent = greatest(extent, magnitude(shifted));
  }
}

template <class Wide>
TOUCHSTONE_INLINE void place_pair(const PoseRecord& X_WA, const VertexRecord& a, const PoseRecord& X_WB,
                                  const VertexRecord& b, OneHullPair& out) {
  Wide reach{}, extent{};
  place_vertices<Wide>(X_WA, a, reach, out.a);
  place_vertices<Wide>(X_WB, b, reach, out.b);
  const Point first = {out.a[0], out.a[8], out.a[16]};
  out.origin = broadcast<Double2>(first - Point{X_WA.p[0], X_WA.p[1], X_WA.p[2]});
  shift<Wide>(first, out.a, extent);
  shift<Wide>(first, out.b, extent);
  out.extent = all<Double2>(greatest_lane(extent));
  out.ordinary = (all<Double2>(greatest_lane(reach)) < all<Double2>(kDistanceHigh)) &
                 (out.extent > all<Double2>(kDistanceLow));
}

/// place() of two solids.
template <class Pack>
TOUCHSTONE_INLINE double place_hulls_inline(const PoseRecord& X_WA, const VertexRecord& a_S,
                                            const PoseRecord& X_WB, const VertexRecord& b_S,
                                            VertexRecord& a_W, VertexRecord& b_W, VertexRecord& a,
                                            VertexRecord& b) {
  // Into the world.
  Pack extent{};
  const auto place =
      [](const PoseRecord& X, const VertexRecord& from, VertexRecord& to) __attribute__((always_inline)) {
    for (int i = 0; i < 8; i += Traits<Pack>::lanes) {
      const Vector3Of<Pack> v = {load<Pack>(from.x + i), load<Pack>(from.y + i), load<Pack>(from.z + i)};
      const Vector3Of<Pack> v_W = rotated<Pack>(X.R, v) + broadcast<Pack>(Point{X.p[0], X.p[1], X.p[2]});
      store(v_W.x, to.x + i), store(v_W.y, to.y + i), store(v_W.z, to.z + i);
    }
  };
  place(X_WA, a_S, a_W), place(X_WB, b_S, b_W);
  // About A's first vertex.
  const Vector3Of<Pack> origin = broadcast<Pack>(Point{a_W.x[0], a_W.y[0], a_W.z[0]});
  const auto shift_to = [&](const VertexRecord& from, VertexRecord& to) __attribute__((always_inline)) {
    for (int i = 0; i < 8; i += Traits<Pack>::lanes) {
      const Vector3Of<Pack> v =
          Vector3Of<Pack>{load<Pack>(from.x + i), load<Pack>(from.y + i), load<Pack>(from.z + i)} - origin;
      store(v.x, to.x + i), store(v.y, to.y + i), store(v.z, to.z + i);
      extent = greatest(extent, largest(v));
    }
  };
  shift_to(a_W, a), shift_to(b_W, b);
  return greatest_lane(extent);
}

/// The first vertex of the greatest axis . v, and that value.
template <class Wide>
TOUCHSTONE_INLINE int highest(const double (&v)[24], const Point& axis, double& value) {
  const Projections<Wide> projections(v, axis);
  value = projections.highest();
  return projections.first_at(value);
}

template <class Wide>
struct OneHullPairIn : OneHullPair {};

template <class Wide>
TOUCHSTONE_INLINE Double2 least_along(const OneHullPairIn<Wide>& pair, const Vector3Of<Double2>& axis,
                                      Corner<Double2>& corner) {
  const Point ahead = {axis.x[0], axis.y[0], axis.z[0]};
  double on_a, on_b;
  corner.a = vertex_of(pair.a, highest<Wide>(pair.a, ahead, on_a));
  corner.w = vertex_of(pair.b, highest<Wide>(pair.b, Point{-ahead.x, -ahead.y, -ahead.z}, on_b)) - corner.a;
  return all<Double2>(-(on_b + on_a));
}

template <class Wide>
TOUCHSTONE_INLINE Double2 separation_along(const OneHullPairIn<Wide>& pair, const Vector3Of<Double2>& n) {
  const Point axis = {n.x[0], n.y[0], n.z[0]};
  return all<Double2>(Projections<Wide>(pair.b, axis).lowest() - Projections<Wide>(pair.a, axis).highest());
}

// ---- The search

template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> same(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return (p.x == q.x) & (p.y == q.y) & (p.z == q.z);
}

/// The best candidate so far: its point, and which corners of s it has.
template <class Pack>
struct Nearest {
  Vector3Of<Pack> v;
  Pack square;
  MaskOf<Pack> has[3];

  TOUCHSTONE_INLINE void consider(MaskOf<Pack> valid, Pack its_square, const Vector3Of<Pack>& its_v, int i,
                                  int j) {
    const MaskOf<Pack> better = valid & (its_square < square);
    square = select(better, its_square, square);
    v = select(better, its_v, v);
    for (int k = 0; k < 3; ++k) has[k] = k == i || k == j ? has[k] | better : has[k] & ~better;
  }
};

/// The nearest point of the tetrahedron of s and w. @param holds_origin set where the origin is inside.
/// @tparam kDistinct how many corners of s may differ, the first of them: of equal ones the first counts, and
/// what has no extent holds nothing, so the bits are those of three.
template <int kDistinct, class Pack>
TOUCHSTONE_INLINE Nearest<Pack> nearest_with(const Vector3Of<Pack>& w, const Corner<Pack> (&s)[3],
                                             MaskOf<Pack>& holds_origin) {
  const Pack zero{};
  Nearest<Pack> best{w, dot(w, w), {}};
  Vector3Of<Pack> e[3], moment[3];
  for (int i = 0; i < kDistinct; ++i) {
    e[i] = s[i].w - w;
    moment[i] = cross(w, e[i]);
    const Pack length2 = dot(e[i], e[i]), along = -dot(w, e[i]);
    const Pack square = dot(moment[i], moment[i]) / length2;
    best.consider((along > zero) & (along < length2), square, w + (along / length2) * e[i], i, i);
  }
  holds_origin = MaskOf<Pack>{};
  // One face of two corners and w, three of three.
  constexpr int kFaces = kDistinct == 3 ? 3 : kDistinct - 1;
  Pack height[3], volume{};
  for (int i = 0; i < kFaces; ++i) {
    const int j = (i + 1) % 3;
    const Vector3Of<Pack> n = cross(e[i], e[j]);
    height[i] = dot(w, n);
    if (i == 0 && kDistinct == 3) volume = dot(e[2], n);
    const Pack n_square = dot(n, n);
    const Pack part_j = dot(moment[i], n), part_i = -dot(moment[j], n);
    const Pack share = height[i] / n_square;
    best.consider((part_i > zero) & (part_j > zero) & (part_i + part_j < n_square), share * height[i],
                  share * n, i, j);
  }
  if constexpr (kDistinct == 3) {
    // -w = sum of x_i e_i with x_i * volume = -height of the face across from s_i.
    const Pack sum_x = -((height[0] + height[1]) + height[2]);
    const Pack low = -greatest(greatest(height[0], height[1]), height[2]);
    const Pack high = -least(least(height[0], height[1]), height[2]);
    holds_origin = ((low > zero) & (sum_x < volume)) | ((high < zero) & (sum_x > volume));
  }
  return best;
}

/// One step of the lanes that are open. @tparam kDistinct as nearest_with() has it
template <int kDistinct, class Pair, class Pack>
TOUCHSTONE_INLINE void search_step(const Pair& pair, Pack tolerance, Search<Pack>& search, MaskOf<Pack>& open,
                                   MaskOf<Pack>& found) {
  using Mask = MaskOf<Pack>;
  // Ends a lane where no vertex of W is nearer than its point, or none is new.
  Corner<Pack> corner;
  const Pack gap = search.square - least_along(pair, search.v, corner);
  Mask ends = (gap <= Pack{}) | (gap * gap <= (tolerance * tolerance) * search.square);
  for (int i = 0; i < kDistinct; ++i) ends |= same(corner.w, search.s[i].w);
  found |= open & ends;
  open &= ~ends;
  if (!bits(open)) return;
  // Else the simplex takes the vertex in.
  Mask holds_origin;
  const Nearest<Pack> next = nearest_with<kDistinct>(corner.w, search.s, holds_origin);
  open &= ~holds_origin;
  const Mask nearer = next.square < search.square;
  found |= open & ~nearer;
  open &= nearer;
  search.v = select(open, next.v, search.v);
  search.square = select(open, next.square, search.square);
  for (int i = 0; i < 3; ++i) {
    const Mask replaced = open & ~next.has[i];
    search.s[i] = {select(replaced, corner.w, search.s[i].w), select(replaced, corner.a, search.s[i].a)};
  }
}

/// Lanes where it ended with a point of W nearest the origin, to rounding.
template <class Pair, class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> search_nearest(const Pair& pair, Search<Pack>& search) {
  using Mask = MaskOf<Pack>;
  // From the vertex of W that is least along the difference of the solids' middles.
  const Vector3Of<Pack> start =
      (vertex_of(pair.b, 0) - vertex_of(pair.a, 0)) + (vertex_of(pair.b, 7) - vertex_of(pair.a, 7));
  Corner<Pack> corner;
  least_along(pair, start, corner);
  for (Corner<Pack>& each : search.s) each = corner;
  search.v = corner.w;
  search.square = dot(corner.w, corner.w);
  const Pack tolerance = all<Pack>(kSearchRoundoffs * kU) * pair.extent;
  Mask open = pair.ordinary, found{};
  // The simplex is a point first, and then two at most.
  search_step<1>(pair, tolerance, search, open, found);
  if (bits(open)) search_step<2>(pair, tolerance, search, open, found);
  for (int step = 2; step < kSearchSteps && bits(open); ++step)
    search_step<3>(pair, tolerance, search, open, found);
  return found;
}

// ---- The judgement

/// The nearest point of the flat through the corners: a plane, a line when two are the same, or a point.
template <class Pack>
struct Foot {
  Vector3Of<Pack> direction;  // from the origin to it, any length; a plane's is its normal
  MaskOf<Pack> in_plane;
  Pack weight[3];
};

template <class Pack>
TOUCHSTONE_INLINE Foot<Pack> foot_of(const Corner<Pack> (&s)[3]) {
  const Pack one = all<Pack>(1.0);
  const Vector3Of<Pack>&p = s[0].w, &q = s[1].w, &r = s[2].w;
  const MaskOf<Pack> p_is_q = same(p, q), p_is_r = same(p, r);
  const Vector3Of<Pack> e = select(p_is_q, r, q) - p;
  const Pack part = where<Pack>(~(p_is_q & p_is_r), -dot(p, e) / dot(e, e));
  const Pack on_line[3] = {one - part, where<Pack>(~p_is_q, part), where<Pack>(p_is_q, part)};

  const Vector3Of<Pack> n = cross(q - p, r - p);
  const Pack area[3] = {dot(n, cross(q, r)), dot(n, cross(r, p)), dot(n, cross(p, q))};
  const Pack total = (area[0] + area[1]) + area[2];
  Foot<Pack> out;
  out.in_plane = ~(p_is_q | p_is_r | same(q, r));
  out.direction = select(out.in_plane, with_sign_of(one, dot(n, p)) * n, p + part * e);
  for (int i = 0; i < 3; ++i) out.weight[i] = select(out.in_plane, area[i] / total, on_line[i]);
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> combination(const Foot<Pack>& foot, const Vector3Of<Pack>& p,
                                              const Vector3Of<Pack>& q, const Vector3Of<Pack>& r) {
  return (foot.weight[0] * p + foot.weight[1] * q) + foot.weight[2] * r;
}

template <class Pair>
TOUCHSTONE_INLINE LaneDistances<typename Pair::Pack> hull_distance_lanes(const Pair& pair) {
  using Pack = typename Pair::Pack;
  LaneDistances<Pack> out{};
  out.tried = ~MaskOf<Pack>{};
  Search<Pack> search;
  out.fits = search_nearest(pair, search);
  if (!bits(out.fits)) return out;
  const Foot<Pack> foot = foot_of(search.s);
  const Corner<Pack>(&s)[3] = search.s;
  const Vector3Of<Pack> point = combination(foot, s[0].w, s[1].w, s[2].w);
  const Pack length = square_root(dot(foot.direction, foot.direction));
  out.n = {foot.direction.x / length, foot.direction.y / length, foot.direction.z / length};
  out.separation = select(foot.in_plane, dot(out.n, s[0].w), length);
  const Pack lower = separation_along(pair, out.n);
  const Pack tolerance = all<Pack>(kDistanceGap) * pair.extent;
  const Pack least_weight = least(least(foot.weight[0], foot.weight[1]), foot.weight[2]);
  out.fits &= (foot.in_plane | (length > all<Pack>(kShortShare) * pair.extent)) &
              (magnitude(out.separation - lower) <= tolerance) &
              (sum(point - out.separation * out.n) <= tolerance) & (least_weight >= Pack{});
  out.certain = lower > all<Pack>(kDistanceRoundoffs * kU) * pair.extent;
  out.from_A = pair.origin + combination(foot, s[0].a, s[1].a, s[2].a);
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE void compute_hull_distances_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                                     const PairIndices* pairs, std::size_t count,
                                                     DistanceRecord* out) {
  for_each_lanes<Pack>(poses, shapes, pairs, count,
                       [&](std::size_t first, std::size_t here, const auto& poses_a, const auto& shapes_a,
                           const auto& poses_b, const auto& shapes_b) {
                         HullLanes<Pack> pair;
                         gather_hulls<Pack>(poses_a, shapes_a, poses_b, shapes_b, pair);
                         store_distances(hull_distance_lanes(pair), here, out + first);
                       });
}

/// One pair has the same bits: lanes never mix, and of vertices level with each other the first is taken.
template <class Wide>
TOUCHSTONE_INLINE void compute_hull_distance_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                                    const PairIndices& indices, DistanceRecord* out) {
  OneHullPairIn<Wide> pair;
  place_pair<Wide>(poses[indices.a], shapes[indices.a], poses[indices.b], shapes[indices.b], pair);
  store_distances(hull_distance_lanes(pair), 1, out);
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
