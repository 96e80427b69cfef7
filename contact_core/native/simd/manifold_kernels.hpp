#pragma once

#include "touchstone/contact_core/native/simd/depth_kernels.hpp"

// Manifolds of boxes and parallelepipeds, pairs in lanes: the contact faces of two solids, clipped against
// each other in projection along the contact normal n. The rules are those of manifold.hpp; a parallelogram's
// edges come in two parallel pairs, so that four cross products determine all crossings.
//
// Notation. u = 2^-53, lengths in the plane across n: a_0, a_1 half edges of A's face, counter-clockwise seen
// against n, b_0, b_1 B's; d from A's face centre to B's; C_ij = a_i x b_j, area_A = a_0 x a_1, area_B. Edge
// 0 runs along a_0 at -a_1, edge 1 along a_1 at a_0, and so on round; t in [-1, 1] is the place on it. A's
// edge o + t w lies between the two lines along b_j where
//
//   |cross(d, b_j) - cross(o, b_j) - t cross(w, b_j)| <= area_B  (Liang, Barsky 1984, in B's oblique frame),
//
// and B's edge between A's lines likewise.
//
// Pairs that fit. Faces at a cosine c >= 1/2 to n whose corners, seen along n, have sines of at least 1/2.
// That holds for every pair of boxes: of three orthogonal normals one is at c >= 3^-1/2 to a unit n, and a
// right angle seen along n keeps a sine of at least c.
//
// Error. size = the sum of all half edges, centres and |T|_1, P = |p_A|_inf + |p_B|_inf. A projected
// coordinate is off by 8 u |v|, of d by 12 u size; cross(d, b_j) by 24 u size |b_j|, C_ij by 20 u |a_i|
// |b_j|, so the corner lies on its own edge and within 48 u size of the lines that cut it; 8 more where
// edges are parallel to rounding. Beyond two sides of a corner of 30 degrees that is 4 times as much, on a
// face at cosine c by 1 / c more: 640 u size. The other face's plane is met to 32 u size along n. Off the
// hull of the rounded world vertices: by another 32 u size + 4 u P + D (box_box_overlap.cpp,
// parallelepiped_overlap.cpp), D <= 16 u size both deviations. With size <= 8 S: 6e3 u S < 2^-40 S in all.
// Faces right-angled and across n: 4 and 1 / c are 2^1/2 and 1. Seen: see manifold.hpp.

namespace touchstone::native::TOUCHSTONE_ISA {

/// Parallel edges no further apart than this many u * size coincide: a few times the usual error of the
/// distance between them.
constexpr double kCoincideRoundoffs = 8.0;
/// Edges are parallel to rounding when moving one across by that moves their crossing by more than this
/// part of the other's half.
constexpr double kParallelPart = 0x1p-19;
/// Lines' crossings stay finite: below what C_ij rounds by, over size^2.
constexpr double kLeastCross = 0x1p-160;
/// Flush edges: see manifold.hpp.
constexpr double kFlush = kFlushEdges;
/// Edges left shorter than this part of the size are dropped.
constexpr double kShortestPart = 0x1p-44;
/// As deep as the pair: in u * size and u * P. The corners' separations of faces flat on each other differ
/// from the pair's by a few; beyond this the witness point is added.
constexpr double kAsDeepSize = 20.0;
constexpr double kAsDeepPosition = 4.0;
/// Boxes thinner than this many u * (size + P) are left to scalar code.
constexpr double kThinRoundoffs = 256.0;
/// And parallelepipeds that deviate by more than this many u * size, or have a steep face or a sharp corner.
constexpr double kClipDeviationRoundoffs = 16.0;
constexpr double kSteepFace = 0.5;
constexpr double kSharpCorner = 0.5;

/// The face of a solid that is clipped.
template <class Pack>
struct ContactFace {
  Vector3Of<Pack> normal;   ///< normal . n = 1
  Vector3Of<Pack> centre;   ///< about A's p
  Vector3Of<Pack> half[2];  ///< half edges, in the order of the polygon
  Pack index;               ///< of Hexahedron::kFaceVertices
  Pack lean;                ///< cosine between its normal and n
  Pack least_height;        ///< half of the solid's heights are at least this
};

/// +x, +y, +z have their edges in cyclic order, -x, -y, -z the other way round; seen from inside (B), the
/// second runs back. @param sense 1 for A, -1 for B
template <bool kIsBox, class Pack>
TOUCHSTONE_INLINE ContactFace<Pack> contact_face(const DepthSolid<Pack>& s, const Vector3Of<Pack>& centre,
                                                 const Vector3Of<Pack>& n, Pack sense) {
  const Normals<Pack> normals(s);
  Pack lean[3], magnitude_of[3];
  Vector3Of<Pack> half[3];
  for (int i = 0; i < 3; ++i) {
    lean[i] = dot(normals.of[i], n), magnitude_of[i] = magnitude(lean[i]);
    if constexpr (!kIsBox) magnitude_of[i] = magnitude_of[i] / square_root(dot(normals.of[i], normals.of[i]));
    half[i] = s.half[i] * s.direction[i];
  }
  // The axis that leans least against n; the first of equal ones.
  const Pack same = all<Pack>(hull_clip::kSameLean);
  const MaskOf<Pack> over_first = magnitude_of[1] > magnitude_of[0] + same;
  const Pack best = over_first ? magnitude_of[1] : magnitude_of[0];
  const MaskOf<Pack> third = magnitude_of[2] > best + same;
  const OneOfThree<Pack> main = {~over_first & ~third, over_first & ~third};
  const Vector3Of<Pack> next[3] = {half[1], half[2], half[0]}, after[3] = {half[2], half[0], half[1]};

  ContactFace<Pack> out;
  // Its face on the side of n, and the half edges as seen from A's outside.
  const Pack along = main.of(lean);
  out.normal = (all<Pack>(1.0) / along) * main.of(normals.of);
  const MaskOf<Pack> positive = sense * along > Pack{};
  const Pack side = positive ? all<Pack>(1.0) : all<Pack>(-1.0);
  out.centre = centre + side * main.of(half);
  const Vector3Of<Pack> second = main.of(next), third_half = main.of(after);
  out.half[0] = select<Pack>(positive, second, third_half);
  out.half[1] = sense * select<Pack>(positive, third_half, second);
  const Pack axis = main.first ? Pack{} : (main.second ? all<Pack>(2.0) : all<Pack>(4.0));
  out.index = axis + (positive ? all<Pack>(1.0) : Pack{});
  out.lean = third ? magnitude_of[2] : best;
  out.least_height = least(least(s.half[0], s.half[1]), s.half[2]);
  if constexpr (!kIsBox) out.least_height = out.least_height * normals.volume;
  return out;
}

template <class Pack>
struct Vector2Of {
  Pack x, y;
};

template <class Pack>
TOUCHSTONE_INLINE Pack cross(const Vector2Of<Pack>& p, const Vector2Of<Pack>& q) {
  return p.x * q.y - p.y * q.x;
}
template <class Pack>
TOUCHSTONE_INLINE Pack dot(const Vector2Of<Pack>& p, const Vector2Of<Pack>& q) {
  return p.x * q.x + p.y * q.y;
}

/// Across n, as tangent_frame() has it.
template <class Pack>
struct PlaneAcross {
  Vector3Of<Pack> x, y;

  TOUCHSTONE_INLINE explicit PlaneAcross(const Vector3Of<Pack>& n)
      : PlaneAcross(n, n.z < Pack{} ? -all<Pack>(1.0) : all<Pack>(1.0)) {}
  /// @param sign 1 or -1, n.z's
  TOUCHSTONE_INLINE PlaneAcross(const Vector3Of<Pack>& n, Pack sign) {
    const Pack one = all<Pack>(1.0);
    const Pack a = -one / (sign + n.z), b = n.x * n.y * a;
    x = {one + sign * (n.x * n.x * a), sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
  TOUCHSTONE_INLINE Vector2Of<Pack> of(const Vector3Of<Pack>& p) const { return {dot(p, x), dot(p, y)}; }
};

/// The parts of four edges that are left: [from, to], nothing when from >= to.
template <class Pack>
struct FourParts {
  Pack from[4], to[4];
};

/// Crossings of one face's edges with the other's lines, k = 0, 1: lines along the other's half edge k.
template <class Pack>
struct Crossings {
  Pack offset[2];      ///< cross(from the face's centre to the other's, line)
  Pack across[2][2];   ///< [edge direction][line]: cross(edge, line), for B as cross(line, edge)
  Pack inverse[2][2];  ///< of that
  Pack reach[2][2];    ///< half the distance of both lines from each other, measured in t
};

template <class Pack>
TOUCHSTONE_INLINE FourParts<Pack> clip_edges(const Crossings<Pack>& c) {
  const Pack one = all<Pack>(1.0);
  FourParts<Pack> out;
  for (int e = 0; e < 4; ++e) {
    const int w = e % 2, o = 1 - w;  // runs along half edge w, at plus or minus half edge o
    out.from[e] = -one, out.to[e] = one;
    for (int k = 0; k < 2; ++k) {
      // Edges 0 and 3 lie at -o, 1 and 2 at +o; 2 and 3 run backwards.
      const Pack side = e == 0 || e == 3 ? c.offset[k] + c.across[o][k] : c.offset[k] - c.across[o][k];
      const Pack middle = e < 2 ? side * c.inverse[w][k] : -(side * c.inverse[w][k]);
      out.from[e] = greatest(middle - c.reach[w][k], out.from[e]);
      out.to[e] = least(middle + c.reach[w][k], out.to[e]);
    }
  }
  return out;
}

/// Bits of a lane, one word a lane.
template <class Pack>
struct LaneBits {
  MaskOf<Pack> words = MaskOf<Pack>{};

  TOUCHSTONE_INLINE void add(MaskOf<Pack> where, int bit) {
    words |= where & (MaskOf<Pack>{} + (1LL << bit));
  }
};

/// Which of B's edges lie along which of A's, by [i][j]: bit 3 (2 i + j) + 0: A's edge i and that of B's
/// edges j, j + 2 that runs the same way, + 1: A's edge i + 2 and the other, + 2: A's edge i and B's j run
/// the same way.
constexpr int kFlushBits = 12;

template <class Pack>
struct PlaneFaces {
  Vector2Of<Pack> a[2], b[2], d;
  Pack a2[2], b2[2];  ///< squares of the half edges
  Pack area_a, area_b;
  Pack size;
};

/// Handles the rare edges that are parallel to rounding, or flush.
template <class Pack>
TOUCHSTONE_INLINE void settle_parallel(const PlaneFaces<Pack>& p, Crossings<Pack>& of_a,
                                       Crossings<Pack>& of_b, LaneBits<Pack>& flush) {
  const Pack tolerance = all<Pack>(kCoincideRoundoffs * kU) * p.size, zero = Pack{};
  const Pack tolerance2 = tolerance * tolerance, flush2 = all<Pack>(kFlush * kFlush);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Pack C = of_a.across[i][j], inverse = magnitude(of_a.inverse[i][j]);
      const MaskOf<Pack> aligned = C * C <= flush2 * (p.a2[i] * p.b2[j]);
      const Pack slack_a = tolerance * (magnitude(p.b[j].x) + magnitude(p.b[j].y));
      const Pack slack_b = tolerance * (magnitude(p.a[i].x) + magnitude(p.a[i].y));
      const Pack part = all<Pack>(kParallelPart);
      // A's edge is kept when no more than the tolerance outside. B's too where both count as one edge, else
      // when more than that inside.
      const MaskOf<Pack> kept = aligned | (slack_a * inverse > part);
      of_a.reach[i][j] = (p.area_b + (kept ? slack_a : zero)) * inverse;
      of_b.reach[j][i] =
          (p.area_a + (aligned ? slack_b : (slack_b * inverse > part ? -slack_b : zero))) * inverse;

      const MaskOf<Pack> same_direction = dot(p.a[i], p.b[j]) > zero;
      const Pack beside =
          i == 0 ? -of_a.across[1][j] : of_a.across[0][j];  // cross(offset of A's edge i, b_j)
      const Pack half = same_direction ? p.area_b : -p.area_b;
      const Pack near2 = p.b2[j] * (flush2 * least(p.a2[i], p.b2[j]) + all<Pack>(16.0) * tolerance2);
      const Pack first = (beside - of_a.offset[j]) - half, second = (-beside - of_a.offset[j]) + half;
      flush.add(aligned & (first * first <= near2), kFlushBits / 4 * (2 * i + j));
      flush.add(aligned & (second * second <= near2), kFlushBits / 4 * (2 * i + j) + 1);
      flush.add(same_direction, kFlushBits / 4 * (2 * i + j) + 2);
    }
  }
}

/// A pair's corners, by edge (0-3: A's, 4-7: B's), as points for the caller.
template <class Pack>
struct CornerLanes {
  PointRecord points[8][Traits<Pack>::lanes];
  LaneBits<Pack> flags;  ///< see CornerFlags
  LaneBits<Pack> flush;
  Pack face_a, face_b;
};

/// Bits by edge from these on; then single ones.
struct CornerFlags {
  static constexpr int kLeft = 0;    ///< an edge of the common region
  static constexpr int kNear = 8;    ///< its corner is within the limit
  static constexpr int kDeep = 16;   ///< and as deep as the pair
  static constexpr int kTurns = 24;  ///< four bits, C_ij >= 0: 00, 10, 01, 11
  static constexpr int kFits = 28;
};

/// Data that all corners of the lanes' pairs share.
template <class Pack>
struct ContactLanes {
  Vector3Of<Pack> n, p_WA;
  Pack separation, limit, deep;  ///< deep: separations up to here are as deep as the pair's; limit: at least
  MaskOf<Pack> swapped;
};

/// The corners on one face's edges. `heights`: how far the other face's plane is along n, at the face's
/// centre and its change along both half edges.
template <class Pack>
TOUCHSTONE_INLINE void write_corners(const ContactLanes<Pack>& contact, const ContactFace<Pack>& face,
                                     const Pack (&height)[3], const FourParts<Pack>& parts,
                                     const Pack (&shortest2)[2], bool is_b, CornerLanes<Pack>& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  for (int e = 0; e < 4; ++e) {
    const int w = e % 2, o = 1 - w, edge = (is_b ? 4 : 0) + e;
    const Pack place = e < 2 ? parts.from[e] : -parts.from[e];
    const Pack side = all<Pack>(e == 0 || e == 3 ? -1.0 : 1.0);
    const Vector3Of<Pack> p = (face.centre + side * face.half[o]) + place * face.half[w];
    const Pack raw = (height[0] + side * height[1 + o]) + place * height[1 + w];
    // No pair of points lies deeper than the pair; those that rounding puts below are as deep.
    const Pack separation = greatest(raw, contact.separation);
    const Vector3Of<Pack> across = separation * contact.n;
    const Vector3Of<Pack> on_this = p + contact.p_WA;
    const Vector3Of<Pack> on_other = (is_b ? p - across : p + across) + contact.p_WA;
    const MaskOf<Pack> this_first = is_b ? contact.swapped : ~contact.swapped;
    const Vector3Of<Pack> first = select<Pack>(this_first, on_this, on_other);
    const Vector3Of<Pack> second = select<Pack>(this_first, on_other, on_this);

    double *head[kLanes], *tail[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      head[l] = (double*)&out.points[edge][l];
      tail[l] = head[l] + 4;
    }
    const Pack heads[4] = {first.x, first.y, first.z, second.x};
    const Pack tails[4] = {second.y, second.z, separation, Pack{}};
    scatter(heads, head);
    scatter(tails, tail);

    const Pack part = parts.to[e] - parts.from[e];
    const MaskOf<Pack> left = (part > Pack{}) & (part * part > shortest2[w]);
    const MaskOf<Pack> near = left & (separation <= contact.limit);
    out.flags.add(left, CornerFlags::kLeft + edge);
    out.flags.add(near, CornerFlags::kNear + edge);
    out.flags.add(near & (separation <= contact.deep), CornerFlags::kDeep + edge);
  }
}

/// The edges' directions in the plane and where each crosses the other face's. @return the largest 1 / |cross
/// product| of two edges.
template <class Pack>
TOUCHSTONE_INLINE Pack cross_edges(const ContactFace<Pack>& a, const ContactFace<Pack>& b,
                                   const PlaneAcross<Pack>& across, PlaneFaces<Pack>& plane,
                                   Crossings<Pack>& of_a, Crossings<Pack>& of_b, CornerLanes<Pack>& out) {
  // Half edges in the plane across the normal.
  for (int k = 0; k < 2; ++k) {
    plane.a[k] = across.of(a.half[k]), plane.b[k] = across.of(b.half[k]);
    plane.a2[k] = dot(plane.a[k], plane.a[k]), plane.b2[k] = dot(plane.b[k], plane.b[k]);
    of_a.offset[k] = cross(plane.d, plane.b[k]), of_b.offset[k] = cross(plane.d, plane.a[k]);
  }
  plane.area_a = cross(plane.a[0], plane.a[1]), plane.area_b = cross(plane.b[0], plane.b[1]);
  // Each edge of A against each of B; an inverse never overflows.
  const Pack size2 = plane.size * plane.size, least_cross = all<Pack>(kLeastCross) * size2;
  Pack steepest = Pack{};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Pack C = cross(plane.a[i], plane.b[j]);
      const Pack inverse = all<Pack>(1.0) / (C + (C < Pack{} ? -least_cross : least_cross));
      of_a.across[i][j] = of_b.across[j][i] = C;
      of_a.inverse[i][j] = of_b.inverse[j][i] = inverse;
      of_a.reach[i][j] = plane.area_b * magnitude(inverse);
      of_b.reach[j][i] = plane.area_a * magnitude(inverse);
      steepest = greatest(magnitude(inverse), steepest);
      out.flags.add(C >= Pack{}, CornerFlags::kTurns + i + 2 * j);
    }
  }
  return steepest;
}

/// Whether both faces are wide enough, and near enough to a parallelogram, for corners found in the plane.
template <bool kIsBox, class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> faces_fit(const ContactFace<Pack>& a, const ContactFace<Pack>& b,
                                         const PlaneFaces<Pack>& plane, Pack position, Pack deviation) {
  const Pack unit_size = all<Pack>(kU) * plane.size, unit_position = all<Pack>(kU) * position;
  const Pack thin = all<Pack>(kThinRoundoffs) * (unit_size + unit_position);
  MaskOf<Pack> fits = (least(a.least_height, b.least_height) > thin) &
                      (plane.size + position < all<Pack>(kOrdinaryHigh)) &
                      (deviation <= all<Pack>(kClipDeviationRoundoffs) * unit_size);
  if constexpr (!kIsBox) {
    const Pack sharp2 = all<Pack>(kSharpCorner * kSharpCorner);
    fits &= (plane.area_a * plane.area_a > sharp2 * (plane.a2[0] * plane.a2[1])) &
            (plane.area_b * plane.area_b > sharp2 * (plane.b2[0] * plane.b2[1])) &
            (least(a.lean, b.lean) >= all<Pack>(kSteepFace));
  }
  return fits;
}

template <class Solid, bool kIsBox, class Pack>
TOUCHSTONE_INLINE void clip_lanes(const Solid& A, const Solid& B, ContactLanes<Pack>& contact,
                                  CornerLanes<Pack>& out) {
  // Magnitudes, and how near to the deepest a point counts as deep.
  const Vector3Of<Pack> T = B.p - A.p;
  PlaneFaces<Pack> plane;
  plane.size = ((A.reach + B.reach) + (A.centre_sum + B.centre_sum)) + sum(T);
  const Pack position = largest(A.p) + largest(B.p), deviation = A.deviation + B.deviation;
  const Pack unit_size = all<Pack>(kU) * plane.size, unit_position = all<Pack>(kU) * position;
  contact.p_WA = A.p;
  contact.deep =
      contact.separation +
      ((all<Pack>(kAsDeepSize) * unit_size + all<Pack>(kAsDeepPosition) * unit_position) + deviation);
  contact.limit = greatest(contact.limit, contact.deep);
  // The two faces that look at each other, and their edges in the plane across n.
  const ContactFace<Pack> a = contact_face<kIsBox, Pack>(A, A.centre, contact.n, all<Pack>(1.0));
  const ContactFace<Pack> b = contact_face<kIsBox, Pack>(B, T + B.centre, contact.n, all<Pack>(-1.0));
  out.face_a = a.index, out.face_b = b.index;

  const PlaneAcross<Pack> across(contact.n);
  const Vector3Of<Pack> d = b.centre - a.centre;
  plane.d = across.of(d);
  Crossings<Pack> of_a, of_b;
  const Pack steepest = cross_edges<Pack>(a, b, across, plane, of_a, of_b, out);
  // Takes in all that settle_parallel() would change: as |a_i| + |b_j| <= size, flush edges have 1 / |C_ij|
  // >= 4 / (kFlush size^2), which 8 u size^2 makes 2^-22.
  const Pack bound = all<Pack>(kParallelPart / 16);
  if (__builtin_expect(bits((all<Pack>(kCoincideRoundoffs) * unit_size * plane.size) * steepest > bound) != 0,
                       0))
    settle_parallel<Pack>(plane, of_a, of_b, out.flush);

  // The corners: each face's edges, clipped by the other face.
  const Pack shortest = all<Pack>(kShortestPart) * plane.size, shortest2 = shortest * shortest;
  const Pack shortest_a[2] = {shortest2 / plane.a2[0], shortest2 / plane.a2[1]};
  const Pack shortest_b[2] = {shortest2 / plane.b2[0], shortest2 / plane.b2[1]};
  const Pack height_a[3] = {dot(b.normal, d), -dot(b.normal, a.half[0]), -dot(b.normal, a.half[1])};
  const Pack height_b[3] = {dot(a.normal, d), dot(a.normal, b.half[0]), dot(a.normal, b.half[1])};
  write_corners<Pack>(contact, a, height_a, clip_edges<Pack>(of_a), shortest_a, false, out);
  write_corners<Pack>(contact, b, height_b, clip_edges<Pack>(of_b), shortest_b, true, out);

  out.flags.add(faces_fit<kIsBox>(a, b, plane, position, deviation), CornerFlags::kFits);
}

// ---- One pair's corners in order

/// The eight edges in the order of their directions from A's edge 0 on, by the four turns' signs; A's edge
/// first where equal.
struct EdgeOrders {
  std::uint32_t edge[16];          ///< four bits a place
  std::uint8_t places[16][2][16];  ///< the places of a set of A's, or B's, edges

  constexpr EdgeOrders() : edge{}, places{} {
    for (unsigned turns = 0; turns < 16; ++turns) fill(turns);
  }

  constexpr unsigned places_of(unsigned turns, unsigned edges) const {
    return places[turns][0][edges & 15u] | unsigned{places[turns][1][edges >> 4 & 15u]};
  }

 private:
  constexpr void fill(unsigned turns) {
    const int first = quadrant(turns & 1u, turns >> 1 & 1u),
              second = quadrant(turns >> 2 & 1u, turns >> 3 & 1u);
    // B's edges 0 to 3 in the quadrants between A's; opposite ones lie opposite.
    const int of_b[4] = {first, second, (first + 2) % 4, (second + 2) % 4};
    int place = 0;
    for (int q = 0; q < 4; ++q) {
      put(turns, q, place++);
      int start = 0;  // the one of this quadrant whose predecessor is in another
      while (start < 4 && !(of_b[start] == q && of_b[(start + 3) % 4] != q)) ++start;
      for (int k = 0; k < 4 && start < 4 && of_b[(start + k) % 4] == q && place < 8; ++k)
        put(turns, 4 + (start + k) % 4, place++);
    }
  }

  constexpr void put(unsigned turns, int e, int place) {
    edge[turns] |= static_cast<std::uint32_t>(e) << 4 * place;
    for (int edges = 0; edges < 16; ++edges)
      if (edges >> e % 4 & 1) places[turns][e / 4][edges] |= static_cast<std::uint8_t>(1 << place);
  }

  /// Between A's edges q and q + 1 lie directions left of edge q and right of the next.
  static constexpr int quadrant(bool left_of_first, bool left_of_second) {
    return left_of_first ? (left_of_second ? 1 : 0) : (left_of_second ? 2 : 3);
  }
};
constexpr EdgeOrders kEdgeOrders;

/// The caller's labels of the eight edges, a byte each; see edge_label() in face_polygon.hpp.
constexpr std::uint64_t kEdgeLabels = 0x0b0a'0908'0302'0100, kSwappedEdgeLabels = 0x0300'0102'0b08'090a;

/// Flush edges go by the name of the caller's first solid.
TOUCHSTONE_INLINE std::uint64_t flush_labels(unsigned long long flush, bool swapped, std::uint64_t labels) {
  const std::uint64_t given = labels;
  const auto join = [&](unsigned of_a, unsigned of_b) {
    const unsigned to = 8 * (swapped ? of_a : 4 + of_b), from = 8 * (swapped ? 4 + of_b : of_a);
    labels = (labels & ~(std::uint64_t{0xff} << to)) | ((given >> from & 0xffu) << to);
  };
  for (unsigned i = 0; i < 2; ++i) {
    for (unsigned j = 0; j < 2; ++j) {
      const unsigned long long bits = flush >> (kFlushBits / 4 * (2 * i + j));
      const bool same_direction = (bits & 4) != 0;
      if (bits & 1) join(i, same_direction ? j : j + 2);
      if (bits & 2) join(i + 2, same_direction ? j + 2 : j);
    }
  }
  return labels;
}

/// Points of one pair from its lane's corners, in order.
template <int kLanes>
TOUCHSTONE_INLINE ClipRecord collect(const PointRecord (&corners)[8][kLanes], int lane,
                                     unsigned long long flags, std::uint64_t labels, std::uint32_t faces,
                                     bool swapped, PointRecord* points) {
  ClipRecord out{0, -1, (flags >> CornerFlags::kFits & 1u) != 0};
  // The corners that are left, in their order about the clip.
  const unsigned turns = flags >> CornerFlags::kTurns & 15u, left = flags >> CornerFlags::kLeft & 0xffu;
  const std::uint32_t order = kEdgeOrders.edge[turns];
  unsigned places = kEdgeOrders.places_of(turns, left);
  const auto edge_at = [order](int place) { return order >> 4 * place & 15u; };
  const auto label_of = [labels](unsigned edge) {
    return static_cast<std::uint32_t>(labels >> 8 * edge & 0xffu);
  };
  // Each is named by the edge that comes in and the one that goes out; equal names are one corner.
  const std::uint32_t first = swapped ? 16 : 1, second = swapped ? 1 : 16;
  std::uint32_t before = label_of(edge_at(31 - __builtin_clz(places | 1u)));
  for (; places != 0; places &= places - 1) {
    const unsigned edge = edge_at(__builtin_ctz(places));
    const std::uint32_t label = label_of(edge);
    const bool keep = (flags >> (CornerFlags::kNear + edge) & 1u) != 0 && label != before;
    const bool deep = (flags >> (CornerFlags::kDeep + edge) & 1u) != 0 && label != before;
    const auto* const from = (const double*)&corners[edge][lane];
    auto* const to = (double*)&points[out.count];
    store(load<Double4>(from), to), store(load<Double4>(from + 4), to + 4);
    points[out.count].feature_id = (1 + first * before + second * label) + faces;
    before = label;
    out.deepest = deep && out.deepest < 0 ? out.count : out.deepest;
    out.count += keep ? 1 : 0;
  }
  return out;
}

/// The same for a task, its names found.
template <int kLanes>
TOUCHSTONE_INLINE ClipRecord collect_task(const ClipTask& task, const PointRecord (&corners)[8][kLanes],
                                          int lane, unsigned long long flags, unsigned long long flush,
                                          double face_a, double face_b) {
  const int names[2] = {static_cast<int>(face_a), static_cast<int>(face_b)};
  const auto faces = static_cast<std::uint32_t>(256 * names[task.swapped] + 4096 * names[!task.swapped]);
  std::uint64_t labels = task.swapped ? kSwappedEdgeLabels : kEdgeLabels;
  if (flush != 0) labels = flush_labels(flush, task.swapped, labels);
  return collect<kLanes>(corners, lane, flags, labels, faces, task.swapped, task.points);
}

template <class Pack, template <class> class Solid, class Record>
TOUCHSTONE_INLINE void clip_inline(const PoseRecord* poses, const Record* shapes, const ClipTask* tasks,
                                   std::size_t count, double max_point_separation, ClipRecord* out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  constexpr std::size_t kAhead = 2 * kLanes;
  for (std::size_t begin = 0; begin < count; begin += kLanes) {
    const std::size_t here = count - begin < kLanes ? count - begin : kLanes;
    const double *poses_a[kLanes], *poses_b[kLanes], *shapes_a[kLanes], *shapes_b[kLanes], *along[kLanes];
    // Whose records each lane reads; lanes beyond the last task repeat it.
    double swapped[kLanes];
    for (std::size_t l = 0; l < kLanes; ++l) {
      const ClipTask& task = tasks[begin + (l < here ? l : here - 1)];
      poses_a[l] = poses[task.pair.a].R, poses_b[l] = poses[task.pair.b].R;
      shapes_a[l] = (const double*)&shapes[task.pair.a], shapes_b[l] = (const double*)&shapes[task.pair.b];
      along[l] = task.n_separation;
      swapped[l] = task.swapped ? 1.0 : 0.0;
    }
    for (std::size_t l = 0; l < kLanes && begin + kAhead + l < count; ++l) {
      prefetch(poses, shapes, tasks[begin + kAhead + l].pair.a);
      prefetch(poses, shapes, tasks[begin + kAhead + l].pair.b);
    }
    // The clip of all lanes.
    Solid<Pack> A, B;
    A.read(poses_a, shapes_a), B.read(poses_b, shapes_b);
    Pack n_separation[4];
    gather(along, n_separation);
    ContactLanes<Pack> contact;
    contact.n = {n_separation[0], n_separation[1], n_separation[2]};
    contact.separation = n_separation[3];
    contact.limit = all<Pack>(max_point_separation);
    contact.swapped = load<Pack>(swapped) > Pack{};
    CornerLanes<Pack> corners;
    constexpr bool kIsBox = sizeof(Record) == sizeof(BoxRecord);
    clip_lanes<Solid<Pack>, kIsBox, Pack>(A, B, contact, corners);

    // Each task picks its points from its lane.
    long long flags[kLanes], flush[kLanes];
    __builtin_memcpy(flags, &corners.flags.words, sizeof flags);
    __builtin_memcpy(flush, &corners.flush.words, sizeof flush);
    double face_a[kLanes], face_b[kLanes];
    store(corners.face_a, face_a), store(corners.face_b, face_b);
    for (std::size_t l = 0; l < here; ++l) {
      out[begin + l] = collect_task<kLanes>(tasks[begin + l], corners.points, static_cast<int>(l),
                                            static_cast<unsigned long long>(flags[l]),
                                            static_cast<unsigned long long>(flush[l]), face_a[l], face_b[l]);
    }
  }
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
