#pragma once

#include "touchstone/contact_core/native/simd/manifold_kernels.hpp"

// The manifold of a single pair of boxes; manifold_kernels.hpp makes those of many, one pair a lane. Here
// lanes of two are the two solids, lanes of four the edges of one face or the crossings of two faces' half
// edges, C_ij in lane 2 i + j. Every value results from the same operations in the same order as in a batch,
// so the bits are the same.

namespace touchstone::native::TOUCHSTONE_ISA {

template <int i, int j, int k, int l>
TOUCHSTONE_INLINE Double4 shuffled(Double4 p) {
  return __builtin_shufflevector(p, p, i, j, k, l);
}
template <int i, int j, int k, int l>
TOUCHSTONE_INLINE Double4 shuffled(Double2 p, Double2 q) {
  return __builtin_shufflevector(p, q, i, j, k, l);
}

/// Both faces: A's in lane 0, B's in lane 1.
struct PairFaces {
  ContactFace<Double2> face;
  Vector3Of<Double2> d;        ///< from A's centre to B's
  Vector2Of<Double2> half[2];  ///< in the plane across n
  Double2 half2[2];            ///< squared
  Double2 area;
  Double2 offset[2];  ///< cross(d, half) there
  double size;

  TOUCHSTONE_INLINE PairFaces(const BoxSolid<Double2>& solids, const Vector3Of<Double2>& T,
                              const Vector3Of<Double2>& n, double size_of)
      : size(size_of) {
    const Vector3Of<Double2> centre = {Double2{0.0, (T.x + solids.centre.x)[1]},
                                       Double2{0.0, (T.y + solids.centre.y)[1]},
                                       Double2{0.0, (T.z + solids.centre.z)[1]}};
    face = contact_face<true, Double2>(solids, centre, n, Double2{1.0, -1.0});
    d = {all<Double2>(face.centre.x[1] - face.centre.x[0]), all<Double2>(face.centre.y[1] - face.centre.y[0]),
         all<Double2>(face.centre.z[1] - face.centre.z[0])};
    const PlaneAcross<Double2> across(n);
    const Vector2Of<Double2> d_across = across.of(d);
    for (int k = 0; k < 2; ++k) {
      half[k] = across.of(face.half[k]);
      half2[k] = dot(half[k], half[k]);
      offset[k] = cross(d_across, half[k]);
    }
    area = cross(half[0], half[1]);
  }
};

/// See Crossings: of both faces, by C_ij.
struct PairCrossings {
  Double4 across, inverse, reach_a, reach_b;
  unsigned long long flush = 0;

  TOUCHSTONE_INLINE explicit PairCrossings(const PairFaces& f) {
    const Vector2Of<Double4> a = {shuffled<0, 0, 2, 2>(f.half[0].x, f.half[1].x),
                                  shuffled<0, 0, 2, 2>(f.half[0].y, f.half[1].y)};
    const Vector2Of<Double4> b = {shuffled<1, 3, 1, 3>(f.half[0].x, f.half[1].x),
                                  shuffled<1, 3, 1, 3>(f.half[0].y, f.half[1].y)};
    across = cross(a, b);
    const Double4 least_cross = all<Double4>(kLeastCross * (f.size * f.size));
    inverse = all<Double4>(1.0) / (across + (across < Double4{} ? -least_cross : least_cross));
    const Double4 steep = magnitude(inverse);
    reach_a = all<Double4>(f.area[1]) * steep, reach_b = all<Double4>(f.area[0]) * steep;
    const double steepness = (kCoincideRoundoffs * (kU * f.size)) * f.size;
    if (bits(all<Double4>(steepness) * steep > all<Double4>(kParallelPart / 16)) != 0) settle(f, a, b, steep);
  }

 private:
  /// As settle_parallel().
  TOUCHSTONE_INLINE void settle(const PairFaces& f, const Vector2Of<Double4>& a, const Vector2Of<Double4>& b,
                                Double4 steep) {
    // Edges that are parallel to rounding cut where their lines do, widened by a slack.
    const Double4 tolerance = all<Double4>((kCoincideRoundoffs * kU) * f.size), zero = {};
    const Double4 flush2 = all<Double4>(kFlush * kFlush), part = all<Double4>(kParallelPart);
    const Double4 a2 = shuffled<0, 0, 2, 2>(f.half2[0], f.half2[1]);
    const Double4 b2 = shuffled<1, 3, 1, 3>(f.half2[0], f.half2[1]);
    const Mask4 aligned = across * across <= flush2 * (a2 * b2);
    const Double4 slack_a = tolerance * (magnitude(b.x) + magnitude(b.y));
    const Double4 slack_b = tolerance * (magnitude(a.x) + magnitude(a.y));
    const Double4 area_a = all<Double4>(f.area[0]), area_b = all<Double4>(f.area[1]);
    const Mask4 kept = aligned | (slack_a * steep > part);
    reach_a = (area_b + (kept ? slack_a : zero)) * steep;
    reach_b = (area_a + (aligned ? slack_b : (slack_b * steep > part ? -slack_b : zero))) * steep;

    // Edges that lie on each other are flush: their corner is left out.
    const Mask4 same_direction = dot(a, b) > zero;
    const Double4 beside = Double4{-1.0, -1.0, 1.0, 1.0} * shuffled<2, 3, 0, 1>(across);
    const Double4 half = same_direction ? area_b : -area_b;
    const Double4 near2 = b2 * (flush2 * least(a2, b2) + all<Double4>(16.0) * (tolerance * tolerance));
    const Double4 offset = shuffled<1, 3, 1, 3>(f.offset[0], f.offset[1]);
    const Double4 first = (beside - offset) - half, second = (-beside - offset) + half;
    const unsigned on_first = bits(aligned & (first * first <= near2));
    const unsigned on_second = bits(aligned & (second * second <= near2)), codirected = bits(same_direction);
    for (unsigned k = 0; k < 4; ++k) {
      const unsigned three = (on_first >> k & 1u) | (on_second >> k & 1u) << 1 | (codirected >> k & 1u) << 2;
      flush |= static_cast<unsigned long long>(three) << (kFlushBits / 4 * k);
    }
  }
};

/// Crossings of a face's edges with the lines along the other's half edges k.
struct PairEdges {
  Double4 offset[2], across[2], inverse[2], reach[2];  // `across` of the half edge that an edge lies off by
};

TOUCHSTONE_INLINE PairEdges edges_of_a(const PairFaces& f, const PairCrossings& c) {
  return {{all<Double4>(f.offset[0][1]), all<Double4>(f.offset[1][1])},
          {shuffled<2, 0, 2, 0>(c.across), shuffled<3, 1, 3, 1>(c.across)},
          {shuffled<0, 2, 0, 2>(c.inverse), shuffled<1, 3, 1, 3>(c.inverse)},
          {shuffled<0, 2, 0, 2>(c.reach_a), shuffled<1, 3, 1, 3>(c.reach_a)}};
}

TOUCHSTONE_INLINE PairEdges edges_of_b(const PairFaces& f, const PairCrossings& c) {
  return {{all<Double4>(f.offset[0][0]), all<Double4>(f.offset[1][0])},
          {shuffled<1, 0, 1, 0>(c.across), shuffled<3, 2, 3, 2>(c.across)},
          {shuffled<0, 1, 0, 1>(c.inverse), shuffled<2, 3, 2, 3>(c.inverse)},
          {shuffled<0, 1, 0, 1>(c.reach_b), shuffled<2, 3, 2, 3>(c.reach_b)}};
}

/// Edges 0 and 3 lie at minus the other half edge, 2 and 3 run backwards.
constexpr Double4 kEdgeSides = {-1.0, 1.0, 1.0, -1.0};
constexpr Double4 kEdgeDirections = {1.0, 1.0, -1.0, -1.0};

struct PairParts {
  Double4 from, to;
};

TOUCHSTONE_INLINE PairParts clip_pair_edges(const PairEdges& c) {
  PairParts out = {all<Double4>(-1.0), all<Double4>(1.0)};
  for (int k = 0; k < 2; ++k) {
    const Double4 side = c.offset[k] - kEdgeSides * c.across[k];
    const Double4 middle = kEdgeDirections * (side * c.inverse[k]);
    out.from = greatest(middle - c.reach[k], out.from);
    out.to = least(middle + c.reach[k], out.to);
  }
  return out;
}

/// Data that a pair's corners share; see ContactLanes.
struct PairContact {
  Vector3Of<Double4> n, p_WA;
  double separation, limit, deep;
  bool swapped;
};

/// The corners on the edges of face `solid`. @param height of the other face's plane: at the centre, along
/// both half edges. @return flags
template <int solid>
TOUCHSTONE_INLINE unsigned long long write_pair_corners(const PairContact& contact,
                                                        const ContactFace<Double2>& face,
                                                        const Double2 (&height)[3], const PairParts& parts,
                                                        const Double2 (&shortest2)[2],
                                                        PointRecord (&points)[8][1]) {
  constexpr int kFirst = 2 * solid, k0 = solid, k1 = 2 + solid;
  const Double4 sides = kEdgeSides, place = kEdgeDirections * parts.from;
  // The corners and their heights over the other face.
  const auto corner = [&](Double2 centre, Double2 half_0, Double2 half_1) {
    return (all<Double4>(centre[solid]) + sides * shuffled<k1, k0, k1, k0>(half_0, half_1)) +
           place * shuffled<k0, k1, k0, k1>(half_0, half_1);
  };
  const Vector3Of<Double4> p = {corner(face.centre.x, face.half[0].x, face.half[1].x),
                                corner(face.centre.y, face.half[0].y, face.half[1].y),
                                corner(face.centre.z, face.half[0].z, face.half[1].z)};
  const Double4 raw = corner(height[0], height[1], height[2]);
  const Double4 separation = greatest(raw, all<Double4>(contact.separation));
  // The points on both solids, in the caller's order.
  const Vector3Of<Double4> across = separation * contact.n;
  const Vector3Of<Double4> on_this = p + contact.p_WA;
  const Vector3Of<Double4> on_other = (solid == 1 ? p - across : p + across) + contact.p_WA;
  // Without a branch: whether a pair is swapped no predictor can guess.
  const Mask4 this_first = Mask4{} - static_cast<long long>((solid == 1) == contact.swapped);
  const Vector3Of<Double4> first = select<Double4>(this_first, on_this, on_other);
  const Vector3Of<Double4> second = select<Double4>(this_first, on_other, on_this);
  double *head[4], *tail[4];
  for (int e = 0; e < 4; ++e) {
    head[e] = (double*)&points[2 * kFirst + e][0];
    tail[e] = head[e] + 4;
  }
  // Written as PointRecords.
  const Double4 heads[4] = {first.x, first.y, first.z, second.x};
  const Double4 tails[4] = {second.y, second.z, separation, Double4{}};
  scatter(heads, head);
  scatter(tails, tail);

  const Double4 part = parts.to - parts.from;
  const Mask4 left =
      (part > Double4{}) & (part * part > shuffled<k0, k1, k0, k1>(shortest2[0], shortest2[1]));
  const Mask4 near = left & (separation <= all<Double4>(contact.limit));
  const Mask4 deep = near & (separation <= all<Double4>(contact.deep));
  const auto at = [](Mask4 mask, int bit) {
    return static_cast<unsigned long long>(bits(mask)) << (bit + 2 * kFirst);
  };
  return at(left, CornerFlags::kLeft) | at(near, CornerFlags::kNear) | at(deep, CornerFlags::kDeep);
}

TOUCHSTONE_INLINE ClipRecord clip_box_pair(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                                           const BoxRecord& b, const ClipTask& task,
                                           double max_point_separation) {
  // Both solids, and the margins that their sizes and places ask for.
  BoxSolid<Double2> solids;
  solids.read({X_WA.R, X_WB.R}, {a.half_extents, b.half_extents});
  const Vector3Of<Double2> T = {all<Double2>(solids.p.x[1] - solids.p.x[0]),
                                all<Double2>(solids.p.y[1] - solids.p.y[0]),
                                all<Double2>(solids.p.z[1] - solids.p.z[0])};
  const double size = (a.reach + b.reach) + sum(T)[0];
  const Double2 coordinate = largest(solids.p);
  const double position = coordinate[0] + coordinate[1], unit_size = kU * size, unit_position = kU * position;
  const double* const n = task.n_separation;
  PairContact contact;
  contact.n = {all<Double4>(n[0]), all<Double4>(n[1]), all<Double4>(n[2])};
  contact.p_WA = {all<Double4>(X_WA.p[0]), all<Double4>(X_WA.p[1]), all<Double4>(X_WA.p[2])};
  contact.separation = n[3];
  contact.deep = n[3] + (kAsDeepSize * unit_size + kAsDeepPosition * unit_position);
  contact.limit = max_point_separation > contact.deep ? max_point_separation : contact.deep;
  contact.swapped = task.swapped;

  // The contact faces, seen along the normal, and where their edges cross.
  const PairFaces f(solids, T, {all<Double2>(n[0]), all<Double2>(n[1]), all<Double2>(n[2])}, size);
  const PairCrossings crossings(f);
  const auto other = [](Double2 p) { return __builtin_shufflevector(p, p, 1, 0); };
  const Vector3Of<Double2> normal = {other(f.face.normal.x), other(f.face.normal.y), other(f.face.normal.z)};
  const Double2 sense = {-1.0, 1.0};
  const Double2 height[3] = {dot(normal, f.d), sense * dot(normal, f.face.half[0]),
                             sense * dot(normal, f.face.half[1])};
  const Double2 shortest = all<Double2>(kShortestPart * size), shortest2 = shortest * shortest;
  const Double2 shortest_of[2] = {shortest2 / f.half2[0], shortest2 / f.half2[1]};
  // Parts of edges inside the other face end in the clip's corners.
  PointRecord points[8][1];
  const PairParts of_a = clip_pair_edges(edges_of_a(f, crossings));
  const PairParts of_b = clip_pair_edges(edges_of_b(f, crossings));
  unsigned long long flags = write_pair_corners<0>(contact, f.face, height, of_a, shortest_of, points);
  flags |= write_pair_corners<1>(contact, f.face, height, of_b, shortest_of, points);

  // The corners' order, and whether the bounds hold for these faces.
  const unsigned turns = bits(crossings.across >= Double4{});  // by 2 i + j, wanted by i + 2 j
  flags |= static_cast<unsigned long long>((turns & 9u) | (turns & 2u) << 1 | (turns & 4u) >> 1)
           << CornerFlags::kTurns;
  const Double2 height_of = f.face.least_height;
  const double least_height = height_of[0] < height_of[1] ? height_of[0] : height_of[1];
  const bool fits =
      least_height > kThinRoundoffs * (unit_size + unit_position) && size + position < kOrdinaryHigh;
  flags |= static_cast<unsigned long long>(fits) << CornerFlags::kFits;
  return collect_task<1>(task, points, 0, flags, crossings.flush, f.face.index[0], f.face.index[1]);
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
