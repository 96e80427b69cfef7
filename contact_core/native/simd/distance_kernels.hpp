#pragma once

#include "touchstone/contact_core/native/simd/depth_axes.hpp"

// The distance of two separated boxes or parallelepipeds, in closed form, pairs in lanes.
//
// W = B - A is a zonotope: T + sum of s_m g_m, |s_m| <= 1, T from A's centre to B's, the generators g_m the
// six half edges. Each of its facets is a parallelogram spanned by two generators (two of A or two of B: a
// face against a vertex; one of each: edge against edge), and the point of W nearest the origin lies on the
// facet whose plane has the origin furthest outside, or on that facet's rim, but for rare pairs. So: take
// that facet from the depth's search of 15 axes, which certified the pair as separated, or search for it; and
// on it find the nearest point.
//
// That this is the nearest point of W is verified. Any n gives a lower bound, n . T - sum |n . g_m|
// for |n| = 1, and any point of W an upper one. Inside the facet n is its normal, and the point must lie at
// height * n; on its rim n is the point's own direction, and both bounds must agree, each time to 16 u *
// extent (the largest coordinate W can have). Pairs that fit neither are left to hull_distance_kernels.hpp.
//
// Two passes. The quick one skips facets of two generators at a sine below 2^-10. The accurate one retries
// the pairs that it leaves: it forms every facet's normal from exact products (Dekker 1971), so that edges at
// any angle above 2^-50 have one, right to 2 u. Their rounding turns that facet by u / sine, but only about
// the edges' common direction, in which it is only sine * |edge| wide: the height changes by u * |edge|.
//
// On the facet at c + s g_1 + t g_2, c its middle: s = n . (g_2 x c) / |n|^2 is off by u |c| / (sine |g_1|),
// which slides the point along both edges; t then follows from s by projection on g_2, so that the point is
// off the normal by sine * |g_1| times the error of s, u |c|. On the rim the point is found with about 100
// bits, so that its direction holds however short it is.
//
// Error. With e as in parallelepiped_overlap.cpp, 32 u (h + t) + 4 u P + 2 D, for what separates the hulls of
// the rounded world vertices from the zonotope: separation is within e + 16 u * extent of the hulls' distance
// (typically a few u). The same bound, with the lower bound's own rounding, 32 u (h + t), certifies that the
// hulls are apart.

namespace touchstone::native::TOUCHSTONE_ISA {

constexpr double kDistanceGap = 16 * kU;
/// Below this share of the extent u * extent / |v| costs the direction of v more than 2^6 u.
constexpr double kShortShare = 0x1p-6;
/// Generators within 8 u of the facet's plane are taken to lie in it.
constexpr double kInPlaneSquare = 0x1p-100;
/// In the accurate pass 2^-50.
constexpr double kThinnestSquare = 0x1p-100;
/// Farther out than 2^12 of the pair's extent the vertices' rounding shows: the hulls are no parallelepipeds
/// any more.
constexpr double kFar = 0x1p12;
/// Tenth powers of lengths are formed.
constexpr double kDistanceLow = 0x1p-64;
constexpr double kDistanceHigh = 0x1p64;

template <class Pack>
struct Zonotope {
  Vector3Of<Pack> generator[6];  // A's half edges, B's
  Vector3Of<Pack> T;
  Vector3Of<Pack> T_low;     // what T's last subtraction lost
  Vector3Of<Pack> centre_A;  // from A's origin, in world axes
  Pack error;                // e + 32 u (h + t)
  MaskOf<Pack> ordinary;     // in magnitudes
  MaskOf<Pack> near;         // to the world's origin: not kFar
};

template <class Pack>
TOUCHSTONE_INLINE Pack within_one(Pack p) {
  return greatest(least(p, all<Pack>(1.0)), all<Pack>(-1.0));
}

template <class Pack>
TOUCHSTONE_INLINE Pack with_sign_of(Pack magnitude_of, Pack sign) {
  using Mask = MaskOf<Pack>;
  const Mask bit = (Mask)all<Pack>(-0.0);
  return (Pack)((bit & (Mask)sign) | (~bit & (Mask)magnitude_of));
}

template <class Pack>
TOUCHSTONE_INLINE Pack where(MaskOf<Pack> mask, Pack p) {
  return (Pack)(mask & (MaskOf<Pack>)p);
}

template <class Pack>
TOUCHSTONE_INLINE void add_where(MaskOf<Pack> mask, const Vector3Of<Pack>& p, Vector3Of<Pack>& to) {
  using Mask = MaskOf<Pack>;
  to.x = (Pack)((Mask)to.x | (mask & (Mask)p.x));
  to.y = (Pack)((Mask)to.y | (mask & (Mask)p.y));
  to.z = (Pack)((Mask)to.z | (mask & (Mask)p.z));
}

/// c + part * g with about 100 bits, part = 1, -1 or any.
template <class Pack>
TOUCHSTONE_INLINE void add_wide(Pack part, const Vector3Of<Pack>& g, Wide<Pack> (&c)[3]) {
  c[0] = c[0] + exact_product(part, g.x);
  c[1] = c[1] + exact_product(part, g.y);
  c[2] = c[2] + exact_product(part, g.z);
}

/// The part of c across g: of short c, which rounding would turn.
template <class Pack>
TOUCHSTONE_INLINE void move_across(const Vector3Of<Pack>& g, MaskOf<Pack> moves, Wide<Pack> (&c)[3]) {
  const Wide<Pack> along = (c[0] * g.x + c[1] * g.y) + c[2] * g.z;
  const Wide<Pack> square = (exact_product(g.x, g.x) + exact_product(g.y, g.y)) + exact_product(g.z, g.z);
  // -along / square in two steps.
  const Pack first = where<Pack>(moves, -along.high / square.high);
  const Wide<Pack> rest = along + square * first;
  const Pack second = where<Pack>(moves, -rest.high / square.high);
  add_wide(first, g, c);
  add_wide(second, g, c);
}

template <bool accurate, class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> normal_of(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  if constexpr (accurate)
    return accurate_cross(p, q);
  else
    return cross(p, q);
}

/// Of the facets the one whose plane has the origin furthest outside, as the indices of its generators;
/// `outside`: some plane has.
template <class Pack>
struct FacetChoice {
  Pack first, second;
  MaskOf<Pack> outside;
};

/// Of an axis of the depth's search (DepthRecord::axis) the generators that span its facet.
constexpr double kFacetOfAxis[2][15] = {{1, 0, 0, 4, 3, 3, 0, 0, 0, 1, 1, 1, 2, 2, 2},
                                        {2, 2, 1, 5, 5, 4, 3, 4, 5, 3, 4, 5, 3, 4, 5}};

/// @param axes of `count` pairs, the last of which fills the lanes beyond
template <class Pack>
TOUCHSTONE_INLINE FacetChoice<Pack> facets_of(const std::uint8_t* axes, std::size_t count) {
  constexpr std::size_t kLanes = Traits<Pack>::lanes;
  double first[kLanes], second[kLanes];
  for (std::size_t l = 0; l < kLanes; ++l) {
    const std::uint8_t axis = axes[l < count ? l : count - 1];
    first[l] = kFacetOfAxis[0][axis], second[l] = kFacetOfAxis[1][axis];
  }
  return {load<Pack>(first), load<Pack>(second), ~MaskOf<Pack>{}};
}

template <bool accurate, class Pack>
TOUCHSTONE_INLINE FacetChoice<Pack> choose_facet(const Zonotope<Pack>& W) {
  const Vector3Of<Pack>(&g)[6] = W.generator;
  Pack square[6];
  for (int k = 0; k < 6; ++k) square[k] = dot(g[k], g[k]);
  // Of n = g_k x g_l, k < l: |n . T|, the sum of |n . g_m| over the others, |n|^2.
  Pack along_T[6][6], width[6][6], n_square[6][6];
  for (int k = 0; k < 6; ++k)
    for (int l = k + 1; l < 6; ++l) width[k][l] = Pack{};
  for (int k = 0; k < 6; ++k) {
    for (int l = k + 1; l < 6; ++l) {
      const Vector3Of<Pack> n = normal_of<accurate>(g[k], g[l]);
      if constexpr (accurate) {
        n_square[k][l] = dot(n, n);
      } else {
        const Pack cosine = dot(g[k], g[l]);
        n_square[k][l] = square[k] * square[l] - cosine * cosine;
      }
      along_T[k][l] = magnitude(dot(n, W.T));
      if constexpr (accurate) {
        // Each from its own normal: another's triple product would be off by u / sine.
        for (int m = 0; m < 6; ++m)
          if (m != k && m != l) width[k][l] += magnitude(dot(n, g[m]));
      } else {
        for (int m = l + 1; m < 6; ++m) {
          const Pack triple = magnitude(dot(n, g[m]));
          width[k][l] += triple;
          width[k][m] += triple;
          width[l][m] += triple;
        }
      }
    }
  }
  // Heights are compared as signed squares: h / |n| > h' / |n'|.
  FacetChoice<Pack> best{Pack{}, all<Pack>(1.0), MaskOf<Pack>{}};
  Pack best_height = all<Pack>(-__builtin_inf()), best_square = all<Pack>(1.0);
  for (int k = 0; k < 6; ++k) {
    for (int l = k + 1; l < 6; ++l) {
      const Pack height = along_T[k][l] - width[k][l];
      const Pack signed_square = height * magnitude(height);
      const MaskOf<Pack> better =
          (signed_square * best_square > best_height * n_square[k][l]) &
          (n_square[k][l] > all<Pack>(accurate ? kThinnestSquare : kThinSquare) * (square[k] * square[l]));
      best_height = select(better, signed_square, best_height);
      best_square = select(better, n_square[k][l], best_square);
      best.first = select(better, all<Pack>(k), best.first);
      best.second = select(better, all<Pack>(l), best.second);
    }
  }
  best.outside = best_height > Pack{};
  return best;
}

template <class Pack>
struct LaneDistances {
  MaskOf<Pack> fits;     // the bounds agree
  MaskOf<Pack> certain;  // the hulls are apart
  MaskOf<Pack> tried;    // no kernel can do better
  Pack separation;
  Vector3Of<Pack> n;
  Vector3Of<Pack> from_A;  // A's witness, from A's origin, in world axes
};

/// c + s g1 + t g2, s and t in [-1, 1], nearest the origin, n = g1 x g2 up to sign: the free minimum;
/// outside, clamped as for two segments (Ericson 2005, section 5.1.9).
template <bool accurate, class Pack>
TOUCHSTONE_INLINE void nearest_on_parallelogram(const Vector3Of<Pack>& c, const Vector3Of<Pack>& g1,
                                                const Vector3Of<Pack>& g2, const Vector3Of<Pack>& n,
                                                Pack n_square, Pack orientation, Pack& s, Pack& t) {
  const Pack g11 = dot(g1, g1), g22 = dot(g2, g2);
  s = within_one(orientation * dot(normal_of<accurate>(g2, c), n) / n_square);
  const Pack t_free = -dot(g2, c + s * g1) / g22;
  t = within_one(t_free);
  const Pack s_rim = within_one(-dot(g1, c + t * g2) / g11);
  s = select(magnitude(t_free) <= all<Pack>(1.0), s, s_rim);
}

/// The facet that faces the origin: c + [-1, 1] g1 + [-1, 1] g2, and the parts of the other generators in c.
template <class Pack>
struct Facet {
  Vector3Of<Pack> g1, g2, c;
  Vector3Of<Pack> n;  ///< g1 x g2 up to sign, away from the origin
  Pack n_square, orientation;
  Pack s[6];  ///< of each generator but these two, in [-1, 1]
};

template <bool accurate, class Pack>
TOUCHSTONE_INLINE Facet<Pack> facet_of(const Zonotope<Pack>& W, const FacetChoice<Pack>& choice,
                                       MaskOf<Pack> lanes) {
  using Mask = MaskOf<Pack>;
  const Vector3Of<Pack>(&g)[6] = W.generator;
  Facet<Pack> facet{};
  Mask free[6];
  for (int m = 0; m < 6; ++m) {
    const Mask is_first = choice.first == all<Pack>(m), is_second = choice.second == all<Pack>(m);
    add_where(is_first, g[m], facet.g1);
    add_where(is_second, g[m], facet.g2);
    free[m] = is_first | is_second;
  }
  facet.n = normal_of<accurate>(facet.g1, facet.g2);
  facet.n_square = dot(facet.n, facet.n);
  const Pack ahead = dot(facet.n, W.T);
  facet.orientation = with_sign_of(all<Pack>(1.0), ahead);
  facet.n = facet.orientation * facet.n;

  // The facet's centre, least along n; generators that lie in the plane wait.
  Mask in_plane[6], any_in_plane = Mask{};
  facet.c = W.T;
  for (int m = 0; m < 6; ++m) {
    const Pack height = dot(facet.n, g[m]);
    in_plane[m] =
        (height * height <= all<Pack>(kInPlaneSquare) * (facet.n_square * dot(g[m], g[m]))) & ~free[m];
    any_in_plane |= in_plane[m];
    facet.s[m] = where(~(free[m] | in_plane[m]), -with_sign_of(all<Pack>(1.0), height));
    facet.c = facet.c + facet.s[m] * g[m];
  }
  // Faces flat on one another: W's facet has more than two generators. One after another brings the point as
  // near as it can.
  if (bits(any_in_plane & lanes) != 0) {
    for (int m = 0; m < 6; ++m) {
      const Pack part = where(in_plane[m], within_one(-dot(g[m], facet.c) / dot(g[m], g[m])));
      facet.s[m] = facet.s[m] + part;
      facet.c = facet.c + part * g[m];
    }
  }
  return facet;
}

/// The nearest point on the facet's rim again, with about 100 bits: one of both generators is at its end, or
/// both are. @return the lanes in which that is so.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> accurate_rim_point(const Zonotope<Pack>& W, const Facet<Pack>& facet, Pack s1,
                                                  Pack s2, Vector3Of<Pack>& v) {
  Wide<Pack> wide[3] = {{W.T.x, W.T_low.x}, {W.T.y, W.T_low.y}, {W.T.z, W.T_low.z}};
  for (int m = 0; m < 6; ++m) add_wide(facet.s[m], W.generator[m], wide);
  const Pack one = all<Pack>(1.0);
  const MaskOf<Pack> end1 = magnitude(s1) == one, end2 = magnitude(s2) == one;
  add_wide(where(end1, s1), facet.g1, wide);
  add_wide(where(end2, s2), facet.g2, wide);
  move_across(facet.g1, ~end1, wide);
  move_across(facet.g2, end1 & ~end2, wide);
  v = {wide[0].high, wide[1].high, wide[2].high};
  return end1 | end2;
}

/// Largest |coordinate| of W [m].
template <class Pack>
TOUCHSTONE_INLINE Pack extent_of(const Zonotope<Pack>& W) {
  const Vector3Of<Pack>(&g)[6] = W.generator;
  Vector3Of<Pack> reach = {magnitude(W.T.x), magnitude(W.T.y), magnitude(W.T.z)};
  for (int m = 0; m < 6; ++m)
    reach = reach + Vector3Of<Pack>{magnitude(g[m].x), magnitude(g[m].y), magnitude(g[m].z)};
  return largest(reach);
}

/// @param choose a Zonotope -> its FacetChoice
template <bool accurate, class Pack, class Choose>
TOUCHSTONE_INLINE LaneDistances<Pack> distance_lanes(const Zonotope<Pack>& W, const Choose& choose) {
  using Mask = MaskOf<Pack>;
  const Vector3Of<Pack>(&g)[6] = W.generator;
  LaneDistances<Pack> out{};
  if (accurate) out.tried = W.ordinary;
  out.fits = W.ordinary & W.near;
  if (bits(out.fits) == 0) return out;
  const FacetChoice<Pack> choice = choose(W);
  if (!accurate) out.fits &= choice.outside;
  if (bits(out.fits) == 0) return out;

  // The point v of that facet nearest the origin.
  const Facet<Pack> facet = facet_of<accurate>(W, choice, out.fits);
  // The depth's search names a thin one where no other axis separates.
  if (!accurate)
    out.fits &= facet.n_square > all<Pack>(kThinSquare) * (dot(facet.g1, facet.g1) * dot(facet.g2, facet.g2));
  Pack s1, s2;
  nearest_on_parallelogram<accurate>(facet.c, facet.g1, facet.g2, facet.n, facet.n_square, facet.orientation,
                                     s1, s2);
  Vector3Of<Pack> v = (facet.c + s1 * facet.g1) + s2 * facet.g2;
  const Pack extent = extent_of(W);
  const Pack tolerance = all<Pack>(kDistanceGap) * extent;
  const Vector3Of<Pack> n_facet = (all<Pack>(1.0) / square_root(facet.n_square)) * facet.n;
  const Pack height = dot(n_facet, facet.c);
  const Mask on_facet = sum(v - height * n_facet) <= tolerance;
  Mask exact_enough = Mask{};
  if constexpr (accurate) {
    if (bits(out.fits & ~on_facet) != 0) exact_enough = accurate_rim_point(W, facet, s1, s2, v);
  }

  // |v| is an upper bound of the distance, the projections' gap along it a lower one: they must agree.
  const Pack v_length = square_root(dot(v, v));
  out.n = select(on_facet, n_facet, (all<Pack>(1.0) / v_length) * v);
  const Pack upper = select(on_facet, height, v_length);
  Pack lower = dot(out.n, W.T);
  Pack width = magnitude(dot(out.n, g[0]));
  for (int m = 1; m < 6; ++m) width = width + magnitude(dot(out.n, g[m]));
  lower = lower - width;
  out.fits &=
      (on_facet | exact_enough | (v_length > all<Pack>(kShortShare) * extent)) & (upper - lower <= tolerance);
  out.certain = lower > W.error;
  out.separation = upper;

  // A's witness point, by the same parts of A's generators.
  out.from_A = W.centre_A;
  const Pack none = Pack{};
  for (int m = 0; m < 3; ++m) {
    const Pack x =
        select(choice.first == all<Pack>(m), s1, select(choice.second == all<Pack>(m), s2, facet.s[m]));
    out.from_A = out.from_A + (none - x) * g[m];
  }
  return out;
}

/// The parts of a Zonotope that both kinds share. `size`: h, `deviation`: D.
template <class Pack>
TOUCHSTONE_INLINE void finish_zonotope(Pack size, Pack position, Pack deviation, Zonotope<Pack>& W) {
  const Pack whole = size + sum(W.T);
  W.error =
      (all<Pack>(kParallelepipedRoundoffs * kU) * whole + all<Pack>(kPositionRoundoffs * kU) * position) +
      all<Pack>(2.0) * deviation;
  W.ordinary = (whole + position < all<Pack>(kDistanceHigh)) & (size > all<Pack>(kDistanceLow));
  W.near = position < all<Pack>(kFar) * whole;
}

template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> rounding_of_difference(const Vector3Of<Pack>& p, const Vector3Of<Pack>& q) {
  return {exact_sum(p.x, -q.x).low, exact_sum(p.y, -q.y).low, exact_sum(p.z, -q.z).low};
}

template <class Pack>
struct BoxZonotope {
  TOUCHSTONE_INLINE static void gather_zonotope(const double* const (&poses_a)[Traits<Pack>::lanes],
                                                const double* const (&shapes_a)[Traits<Pack>::lanes],
                                                const double* const (&poses_b)[Traits<Pack>::lanes],
                                                const double* const (&shapes_b)[Traits<Pack>::lanes],
                                                Zonotope<Pack>& W) {
    BoxLanes<Pack> A, B;
    gather_solid(poses_a, shapes_a, A);
    gather_solid(poses_b, shapes_b, B);
    for (int i = 0; i < 3; ++i) {
      W.generator[i] = A.half[i] * A.axis[i];
      W.generator[3 + i] = B.half[i] * B.axis[i];
    }
    W.T = B.p - A.p;
    W.T_low = rounding_of_difference(B.p, A.p);
    W.centre_A = {Pack{}, Pack{}, Pack{}};
    // |g|_1 <= sqrt(3) * half
    finish_zonotope(all<Pack>(2.0) * (A.reach + B.reach), largest(A.p) + largest(B.p), Pack{}, W);
  }
};

template <class Pack>
struct ParallelepipedZonotope {
  TOUCHSTONE_INLINE static void gather_zonotope(const double* const (&poses_a)[Traits<Pack>::lanes],
                                                const double* const (&shapes_a)[Traits<Pack>::lanes],
                                                const double* const (&poses_b)[Traits<Pack>::lanes],
                                                const double* const (&shapes_b)[Traits<Pack>::lanes],
                                                Zonotope<Pack>& W) {
    ParallelepipedLanes<Pack> A, B;
    gather_solid(poses_a, shapes_a, A);
    gather_solid(poses_b, shapes_b, B);
    for (int i = 0; i < 3; ++i) {
      W.generator[i] = A.edge[i];
      W.generator[3 + i] = B.edge[i];
    }
    W.T = (B.p - A.p) + (B.centre_W - A.centre_W);
    W.T_low = {Pack{}, Pack{}, Pack{}};
    W.centre_A = A.centre_W;
    finish_zonotope((A.size + B.size) + (A.centre_sum + B.centre_sum), largest(A.p) + largest(B.p),
                    A.deviation + B.deviation, W);
  }
};

TOUCHSTONE_INLINE DistanceState distance_state(bool fits, bool certain, bool tried) {
  if (fits && certain) return DistanceState::found;
  if (!tried) return DistanceState::undecided;
  return fits ? DistanceState::if_separated : DistanceState::exhausted;
}

/// The first lane, in stores from which whole vectors may be loaded at once.
TOUCHSTONE_INLINE void store_distance(const LaneDistances<Double2>& distance, DistanceRecord* out) {
  store(Double4{distance.separation[0], distance.n.x[0], distance.n.y[0], distance.n.z[0]}, (double*)out);
  store(Double2{distance.from_A.x[0], distance.from_A.y[0]}, out->from_A);
  out->from_A[2] = distance.from_A.z[0];
  out->state =
      distance_state(bits(distance.fits) & 1u, bits(distance.certain) & 1u, bits(distance.tried) & 1u);
}

/// The first `count` lanes.
template <class Pack>
TOUCHSTONE_INLINE void store_distances(const LaneDistances<Pack>& distances, std::size_t count,
                                       DistanceRecord* out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  if constexpr (kLanes == 2) {
    if (count == 1) return store_distance(distances, out);
  }
  const Pack columns[7] = {distances.separation, distances.n.x,      distances.n.y,     distances.n.z,
                           distances.from_A.x,   distances.from_A.y, distances.from_A.z};
  double rows[7][kLanes];
  for (int k = 0; k < 7; ++k) store(columns[k], rows[k]);
  const unsigned fits = bits(distances.fits), certain = bits(distances.certain);
  const unsigned tried = bits(distances.tried);
  for (std::size_t l = 0; l < count; ++l) {
    DistanceRecord& record = out[l];
    record.state = distance_state(fits >> l & 1u, certain >> l & 1u, tried >> l & 1u);
    record.separation = rows[0][l];
    for (int k = 0; k < 3; ++k) record.n[k] = rows[1 + k][l];
    for (int k = 0; k < 3; ++k) record.from_A[k] = rows[4 + k][l];
  }
}

/// @param choose a Zonotope, the number of its first pair and of its pairs -> their FacetChoice
template <bool accurate, class Pack, template <class> class Kind, class Shape, class Choose>
TOUCHSTONE_INLINE void compute_distances_inline(const PoseRecord* poses, const Shape* shapes,
                                                const PairIndices* pairs, std::size_t count,
                                                DistanceRecord* out, const Choose& choose) {
  for_each_lanes<Pack>(poses, shapes, pairs, count,
                       [&](std::size_t first, std::size_t here, const auto& poses_a, const auto& shapes_a,
                           const auto& poses_b, const auto& shapes_b) {
                         Zonotope<Pack> W;
                         Kind<Pack>::gather_zonotope(poses_a, shapes_a, poses_b, shapes_b, W);
                         const auto choose_here = [&](const Zonotope<Pack>& lanes)
                             __attribute__((always_inline)) {
                           return choose(lanes, first, here);
                         };
                         store_distances(distance_lanes<accurate>(W, choose_here), here, out + first);
                       });
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
