#pragma once

#include "touchstone/contact_core/native/simd/hull_distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/hull_kernels.hpp"

// hull_kernels.hpp for many pairs: hulls of six faces and twelve edges, as most solids have, pairs in lanes.
// Every number results from the same operations in the same order as there, so the bits are the same.
//
// In lanes are placed the vertices, the normals, the other hull seen from each face, and the edges seen from
// each face of the other, on whose signs the crossing of arcs rests. Which of these count is logic on bits,
// pair by pair; the few pairs of edges that are left, and the witness points, are scalar code's.

namespace touchstone::native::TOUCHSTONE_ISA {

template <class Pack>
using HullsOfLanes = const HullRecord * [Traits<Pack>::lanes];

/// A solid in lanes, and the other one as seen from it.
template <class Pack>
struct SolidLanes {
  Vector3Of<Pack> column[3];  // R
  VertexLanes<Pack> vertices;
  Vector3Of<Pack> normal[kLaneFaces];
  Pack height[kLaneFaces];
  Pack along[kLaneFaces][8];  // normal . vertex, of the other's
  Pack low[kLaneFaces];       // the least of these
  Vector3Of<Pack> edge[kLaneEdges];
};

template <class Pack>
struct SolidPairLanes {
  SolidLanes<Pack> a, b;
  Vector3Of<Pack> origin;  // A's first vertex in the world
  Pack extent, position;
  /// Byte f of A's edge e is set where the edge rises above B's face f, or falls below it: both where that is
  /// uncertain.
  MaskOf<Pack> above[kLaneEdges], below[kLaneEdges];
  /// Bit e of A's face f: B's edge e rises above it; bit kBelow + e: it falls below it.
  MaskOf<Pack> edges_over[kLaneFaces];
  static constexpr int kBelow = 16;
};

// ---- Vertices and faces

template <class Pack>
TOUCHSTONE_INLINE void place_pair(const double* const (&poses_a)[Traits<Pack>::lanes],
                                  const double* const (&shapes_a)[Traits<Pack>::lanes],
                                  const double* const (&poses_b)[Traits<Pack>::lanes],
                                  const double* const (&shapes_b)[Traits<Pack>::lanes],
                                  SolidPairLanes<Pack>& out) {
  const PoseLanes<Pack> X_WA = gather_poses<Pack>(poses_a), X_WB = gather_poses<Pack>(poses_b);
  Pack reach{};
  place_vertices<Pack>(shapes_a, X_WA, &X_WA.p, reach, out.a.vertices);
  place_vertices<Pack>(shapes_b, X_WB, &X_WB.p, reach, out.b.vertices);
  out.origin = vertex_of(out.a.vertices, 0);
  out.extent = Pack{};
  shift(out.origin, out.a.vertices, out.extent);
  shift(out.origin, out.b.vertices, out.extent);
  for (int k = 0; k < 3; ++k) out.a.column[k] = X_WA.column[k], out.b.column[k] = X_WB.column[k];
  // As find_hull_depth() has it.
  const Pack near = largest(out.origin) + out.extent;
  const Pack beyond = greatest(largest(X_WA.p), largest(X_WB.p)) - near;
  out.position = near + all<Pack>(kFarRoundoffs) * greatest(beyond, Pack{});
}

/// The vertex whose number a lane has in three bits of its word from `first` on.
template <class Pack>
TOUCHSTONE_INLINE Vector3Of<Pack> vertex_in(MaskOf<Pack> words, int first, const VertexLanes<Pack>& v) {
  using Mask = MaskOf<Pack>;
  Mask bit[3];
  for (int k = 0; k < 3; ++k) bit[k] = (words & (Mask{} + (1LL << (first + k)))) != Mask{};
  const auto chosen = [&bit](const Pack(&p)[8]) __attribute__((always_inline)) {
    const Pack low = select<Pack>(bit[1], select<Pack>(bit[0], p[3], p[2]), select<Pack>(bit[0], p[1], p[0]));
    const Pack high =
        select<Pack>(bit[1], select<Pack>(bit[0], p[7], p[6]), select<Pack>(bit[0], p[5], p[4]));
    return select<Pack>(bit[2], high, low);
  };
  return {chosen(v.x), chosen(v.y), chosen(v.z)};
}

template <class Pack>
TOUCHSTONE_INLINE void pose_faces(const HullsOfLanes<Pack>& hulls, SolidLanes<Pack>& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const double *records[kLanes], *normals[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    records[l] = (const double*)hulls[l];
    normals[l] = hulls[l]->normals[0].x;
  }
  // The vertex of each face is a byte of the record's first word.
  static_assert(__builtin_offsetof(HullRecord, face_vertex) + kLaneFaces <= sizeof(double));
  Pack first[4], local[24];
  gather(records, first);
  gather(normals, local);
  Vector3Of<Pack> N[3];
  for (int i = 0; i < 3; ++i) N[i] = cross(out.column[(i + 1) % 3], out.column[(i + 2) % 3]);
  for (int f = 0; f < kLaneFaces; ++f) {
    const Vector3Of<Pack> n = rotate(N, Vector3Of<Pack>{local[f], local[8 + f], local[16 + f]});
    out.normal[f] = (all<Pack>(1.0) / square_root(dot(n, n))) * n;
    const int byte = static_cast<int>(__builtin_offsetof(HullRecord, face_vertex)) + f;
    out.height[f] = dot(out.normal[f], vertex_in((MaskOf<Pack>)first[0], 8 * byte, out.vertices));
  }
}

template <class Pack>
TOUCHSTONE_INLINE void look_from_faces(const VertexLanes<Pack>& other, SolidLanes<Pack>& base) {
  for (int f = 0; f < kLaneFaces; ++f) {
    for (int v = 0; v < 8; ++v) {
      base.along[f][v] = dot(base.normal[f], vertex_of(other, v));
      base.low[f] = v == 0 ? base.along[f][0] : least(base.along[f][v], base.low[f]);
    }
  }
}

/// HullAxis of a face in lanes.
template <class Pack>
struct FaceAxisLanes {
  Pack separation;
  Vector3Of<Pack> n;  // A to B
  Pack face;          // its number
  MaskOf<Pack> of_b;

  TOUCHSTONE_INLINE void take(MaskOf<Pack> where, const SolidLanes<Pack>& solid, int f, Pack& low) {
    n = select(where, solid.normal[f], n);
    face = select(where, all<Pack>(f), face);
    low = select(where, solid.low[f], low);
  }
};

/// best_face().
template <class Pack>
TOUCHSTONE_INLINE FaceAxisLanes<Pack> best_face(const SolidPairLanes<Pack>& pair) {
  const SolidLanes<Pack>&a = pair.a, &b = pair.b;
  FaceAxisLanes<Pack> best{a.low[0] - a.height[0], a.normal[0], Pack{}, {}};
  Pack low = a.low[0];
  for (int f = 1; f < kLaneFaces; ++f) {
    const Pack separation = a.low[f] - a.height[f];
    const MaskOf<Pack> better = separation > best.separation;
    best.separation = select(better, separation, best.separation);
    best.take(better, a, f, low);
  }
  const Pack tie = all<Pack>(kTieOfExtent * kU) * pair.extent;
  for (int f = 0; f < kLaneFaces; ++f) {
    const Pack separation = b.low[f] - b.height[f];
    const MaskOf<Pack> better = separation > best.separation + tie;
    best.separation = select(better, separation, best.separation);
    best.take(better, b, f, low);
    best.of_b |= better;
  }
  // hull_separation() along that normal, half of which is known.
  Pack high{};
  for (int v = 0; v < 8; ++v) {
    const Pack along = dot(best.n, select(best.of_b, vertex_of(b.vertices, v), vertex_of(a.vertices, v)));
    high = v == 0 ? along : greatest(along, high);
  }
  best.separation = low - high;
  best.n = select(best.of_b, Vector3Of<Pack>{-best.n.x, -best.n.y, -best.n.z}, best.n);
  return best;
}

// ---- Edges

/// Byte f: bit v is set where the other's vertex v lies deeper below face f than `most`.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> deep_vertices(const SolidLanes<Pack>& solid, Pack most) {
  using Mask = MaskOf<Pack>;
  Mask out{};
  for (int f = 0; f < kLaneFaces; ++f) {
    const Pack highest = solid.height[f] - most;
    for (int v = 0; v < 8; ++v) out |= (solid.along[f][v] < highest) & (Mask{} + (1LL << (8 * f + v)));
  }
  return out;
}

template <class Pack>
TOUCHSTONE_INLINE void pose_edge(const HullsOfLanes<Pack>& hulls, int e, SolidLanes<Pack>& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const double* from[kLanes];
  for (int l = 0; l < kLanes; ++l) from[l] = hulls[l]->edges[e].direction;
  Pack local[4];
  gather(from, local);
  out.edge[e] = rotate(out.column, Vector3Of<Pack>{local[0], local[1], local[2]});
}

/// Poses the edges of which some lane has one in question, and looks at them from the other's faces.
template <class Pack>
TOUCHSTONE_INLINE void look_at_edges(const HullsOfLanes<Pack>& hulls_a, unsigned wanted_a,
                                     const HullsOfLanes<Pack>& hulls_b, unsigned wanted_b,
                                     SolidPairLanes<Pack>& pair) {
  using Mask = MaskOf<Pack>;
  const Pack tolerance = all<Pack>(kUncertainSign);
  // A byte of faces for each edge of A.
  for (unsigned rest = wanted_a; rest != 0; rest &= rest - 1) {
    const int e = __builtin_ctz(rest);
    pose_edge(hulls_a, e, pair.a);
    Mask above{}, below{};
    for (int f = 0; f < kLaneFaces; ++f) {
      const Pack height = dot(pair.b.normal[f], pair.a.edge[e]);
      const Mask byte = Mask{} + (0xffLL << (8 * f));
      above |= (height > -tolerance) & byte;
      below |= (height < tolerance) & byte;
    }
    pair.above[e] = above, pair.below[e] = below;
  }
  // A bit of each face for each edge of B.
  for (int f = 0; f < kLaneFaces; ++f) pair.edges_over[f] = Mask{};
  for (unsigned rest = wanted_b; rest != 0; rest &= rest - 1) {
    const int e = __builtin_ctz(rest);
    pose_edge(hulls_b, e, pair.b);
    const Mask above = Mask{} + (1LL << e), below = Mask{} + (1LL << (SolidPairLanes<Pack>::kBelow + e));
    for (int f = 0; f < kLaneFaces; ++f) {
      const Pack height = dot(pair.a.normal[f], pair.b.edge[e]);
      pair.edges_over[f] |= ((height > -tolerance) & above) | ((height < tolerance) & below);
    }
  }
}

/// Of one edge of A, bits of B's edges whose first face it rises above and whose second it falls below; and
/// the other way round.
TOUCHSTONE_INLINE CrossingArcs arcs_across(long long above, long long below, const HullRecord& other) {
  CrossingArcs out{0, 0};
#if defined(__SSSE3__)
  const __m128i is_above = _mm_cvtsi64_si128(above), is_below = _mm_cvtsi64_si128(below);
  const __m128i first = _mm_loadu_si128((const __m128i*)other.edge_faces[0]);
  const __m128i second = _mm_loadu_si128((const __m128i*)other.edge_faces[1]);
  const auto both = [](__m128i p, __m128i q) {
    return static_cast<unsigned>(_mm_movemask_epi8(_mm_and_si128(p, q)));
  };
  out.ahead = both(_mm_shuffle_epi8(is_above, first), _mm_shuffle_epi8(is_below, second));
  out.turned = both(_mm_shuffle_epi8(is_below, first), _mm_shuffle_epi8(is_above, second));
#else
  for (int e = 0; e < kLaneEdges; ++e) {
    const int first = 8 * other.edge_faces[0][e], second = 8 * other.edge_faces[1][e];
    out.ahead |= static_cast<unsigned>(above >> first & below >> second & 1) << e;
    out.turned |= static_cast<unsigned>(below >> first & above >> second & 1) << e;
  }
#endif
  return out;
}

/// One pair of the lanes.
template <class Pack>
struct LaneOf {
  const SolidPairLanes<Pack>& pair;
  int lane;

  TOUCHSTONE_INLINE Point edge(const SolidLanes<Pack>& solid, int e) const {
    const Vector3Of<Pack>& v = solid.edge[e];
    return {v.x[lane], v.y[lane], v.z[lane]};
  }
  /// Of edge e of A: bits of B's edges whose arcs cross its own, and from kTurned on those that do so turned.
  static constexpr int kTurned = 16;
  TOUCHSTONE_INLINE unsigned arcs(const HullRecord& A, int e, const HullRecord& B) const {
    constexpr int kBelow = SolidPairLanes<Pack>::kBelow;
    const CrossingArcs seen = arcs_across(pair.above[e][lane], pair.below[e][lane], B);
    const auto first = static_cast<unsigned>(pair.edges_over[A.edge_faces[0][e]][lane]);
    const auto second = static_cast<unsigned>(pair.edges_over[A.edge_faces[1][e]][lane]);
    const unsigned ahead = seen.ahead & first & second >> kBelow;
    const unsigned turned = seen.turned & first >> kBelow & second;
    return ahead | turned << kTurned;
  }
};

/// search_edges(): the same pairs of edges in the same order.
template <class Wide, class Pack>
TOUCHSTONE_INLINE EdgeSearch search_edges(const LaneOf<Pack>& lane, const PosedHull& A,
                                          unsigned in_question_a, const PosedHull& B, unsigned in_question_b,
                                          double extent, HullAxis& best) {
  constexpr int kTurned = LaneOf<Pack>::kTurned;
  // Listed first: most edges of A have one partner at most, and no predictor can guess which. Flat solids'
  // pairs may be uncertain all of them, and are listed ahead and turned; the last place is for no pair.
  std::uint16_t listed[2 * kLaneEdges * kLaneEdges + 1];
  unsigned count = 0;
  const unsigned counts = in_question_b | in_question_b << kTurned;
  for (unsigned rest_a = in_question_a; rest_a != 0; rest_a &= rest_a - 1) {
    const int i = __builtin_ctz(rest_a);
    unsigned rest = lane.arcs(*A.hull, i, *B.hull) & counts;
    do {
      listed[count] = static_cast<std::uint16_t>(i << 8 | __builtin_ctz(rest | 1u << 31));
      count += rest != 0 ? 1u : 0u;
      rest &= rest - 1;
    } while (__builtin_expect(rest != 0, 0));
  }
  const double face_separation = best.separation;
  for (unsigned k = 0; k < count; ++k) {
    const int i = listed[k] >> 8, j = listed[k] % kTurned;
    const double sign = (listed[k] & kTurned) != 0 ? -1.0 : 1.0;
    const EdgeAxis axis(A, i, lane.edge(lane.pair.a, i), B, j, lane.edge(lane.pair.b, j), sign, extent);
    if (axis.exceeds(face_separation)) continue;
    if (try_edges<Wide>(A, i, B, j, axis, extent, best) == EdgeSearch::too_parallel)
      return EdgeSearch::too_parallel;
  }
  return EdgeSearch::done;
}

// ---- Pairs

/// One pair of the lanes, as the scalar code reads it.
struct PosedLane {
  PosedHull A, B;
};

/// out[l] is where lane l of p, q, r, s goes, `from` doubles on.
template <class Pack>
TOUCHSTONE_INLINE void scatter_at(int from, const Pack& p, const Pack& q, const Pack& r, const Pack& s,
                                  double* const (&out)[Traits<Pack>::lanes]) {
  const Pack four[4] = {p, q, r, s};
  double* at[Traits<Pack>::lanes];
  for (int l = 0; l < Traits<Pack>::lanes; ++l) at[l] = out[l] + from;
  scatter(four, at);
}

template <class Pack>
TOUCHSTONE_INLINE void scatter_vertices(const VertexLanes<Pack>& v,
                                        double* const (&out)[Traits<Pack>::lanes]) {
  for (int half = 0; half < 8; half += 4) {
    scatter_at(half, v.x[half], v.x[half + 1], v.x[half + 2], v.x[half + 3], out);
    scatter_at(8 + half, v.y[half], v.y[half + 1], v.y[half + 2], v.y[half + 3], out);
    scatter_at(16 + half, v.z[half], v.z[half + 1], v.z[half + 2], v.z[half + 3], out);
  }
}

template <class Pack>
TOUCHSTONE_INLINE void scatter_faces(const SolidLanes<Pack>& solid,
                                     PosedHull* const (&to)[Traits<Pack>::lanes]) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const Vector3Of<Pack>* const n = solid.normal;
  const Pack* const h = solid.height;
  const Pack zero{};
  double *nx[kLanes], *ny[kLanes], *nz[kLanes], *height[kLanes];
  for (int l = 0; l < kLanes; ++l)
    nx[l] = to[l]->nx, ny[l] = to[l]->ny, nz[l] = to[l]->nz, height[l] = to[l]->height;
  scatter_at(0, n[0].x, n[1].x, n[2].x, n[3].x, nx), scatter_at(4, n[4].x, n[5].x, zero, zero, nx);
  scatter_at(0, n[0].y, n[1].y, n[2].y, n[3].y, ny), scatter_at(4, n[4].y, n[5].y, zero, zero, ny);
  scatter_at(0, n[0].z, n[1].z, n[2].z, n[3].z, nz), scatter_at(4, n[4].z, n[5].z, zero, zero, nz);
  scatter_at(0, h[0], h[1], h[2], h[3], height), scatter_at(4, h[4], h[5], zero, zero, height);
}

/// `of_extent` u of the extent, and the world vertices' rounding: Magnitudes::rounding().
template <class Pack>
TOUCHSTONE_INLINE Pack rounding_of(const SolidPairLanes<Pack>& pair, double of_extent) {
  return all<Pack>(of_extent * kU) * pair.extent + all<Pack>(kHullPositionRoundoffs * kU) * pair.position;
}

/// The edges in question of each lane, and of any.
template <class Pack>
struct EdgesOfLanes {
  unsigned a[Traits<Pack>::lanes] = {}, b[Traits<Pack>::lanes] = {};
  unsigned any_a = 0, any_b = 0;

  /// @param open bits of the lanes that count
  TOUCHSTONE_INLINE EdgesOfLanes(const SolidPairLanes<Pack>& pair, const HullsOfLanes<Pack>& hulls_a,
                                 const HullsOfLanes<Pack>& hulls_b, Pack depth, unsigned open) {
    const Pack most = greatest(depth, Pack{}) + rounding_of(pair, kPruneRoundoffs);
    const MaskOf<Pack> deep_a = deep_vertices(pair.a, most), deep_b = deep_vertices(pair.b, most);
    for (int l = 0; l < Traits<Pack>::lanes; ++l) {
      if (!(open >> l & 1u)) continue;
      a[l] = edges_without_common(*hulls_a[l], deep_a[l]);
      b[l] = edges_without_common(*hulls_b[l], deep_b[l]);
      // Edges without another to cross are none.
      any_a |= b[l] != 0 ? a[l] : 0u, any_b |= a[l] != 0 ? b[l] : 0u;
    }
  }
};

/// The tasks of the lanes; those beyond the last repeat it.
template <class Pack>
struct TasksOfLanes {
  static constexpr std::size_t kLanes = Traits<Pack>::lanes;

  const HullTask* of[kLanes];
  std::size_t here;  // lanes that count
  HullsOfLanes<Pack> hulls_a, hulls_b;

  TOUCHSTONE_INLINE TasksOfLanes(const HullTask* tasks, std::size_t left)
      : here(left < kLanes ? left : kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      of[l] = tasks + (l < here ? l : here - 1);
      hulls_a[l] = of[l]->a, hulls_b[l] = of[l]->b;
    }
  }
};

template <class Pack>
TOUCHSTONE_INLINE void place_tasks(const PoseRecord* poses, const VertexRecord* shapes,
                                   const TasksOfLanes<Pack>& tasks, SolidPairLanes<Pack>& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const double *poses_a[kLanes], *poses_b[kLanes], *shapes_a[kLanes], *shapes_b[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    const PairIndices pair = tasks.of[l]->pair;
    poses_a[l] = poses[pair.a].R, poses_b[l] = poses[pair.b].R;
    shapes_a[l] = shapes[pair.a].x, shapes_b[l] = shapes[pair.b].x;
  }
  place_pair<Pack>(poses_a, shapes_a, poses_b, shapes_b, out);
}

/// Writes the placed hulls of the tasks.
template <class Pack>
TOUCHSTONE_INLINE void write_placed(const SolidPairLanes<Pack>& pair, const TasksOfLanes<Pack>& tasks) {
  constexpr int kLanes = Traits<Pack>::lanes;
  double *a[kLanes], *b[kLanes], *rest[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    PlacedHulls& placed = *tasks.of[l]->placed;
    a[l] = placed.a, b[l] = placed.b, rest[l] = placed.origin;
  }
  static_assert(__builtin_offsetof(PlacedHulls, padding) ==
                __builtin_offsetof(PlacedHulls, origin) + 3 * sizeof(double));
  scatter_vertices(pair.a.vertices, a), scatter_vertices(pair.b.vertices, b);
  scatter_at(0, pair.origin.x, pair.origin.y, pair.origin.z, Pack{}, rest);
}

/// Writes what scalar code reads.
template <class Pack>
TOUCHSTONE_INLINE void write_posed(const SolidPairLanes<Pack>& pair, const TasksOfLanes<Pack>& tasks,
                                   PosedLane (&out)[Traits<Pack>::lanes]) {
  constexpr int kLanes = Traits<Pack>::lanes;
  PosedHull *a[kLanes], *b[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    PlacedHulls& placed = *tasks.of[l]->placed;
    a[l] = &out[l].A, b[l] = &out[l].B;
    a[l]->hull = tasks.hulls_a[l], a[l]->vertices = placed.a;
    b[l]->hull = tasks.hulls_b[l], b[l]->vertices = placed.b;
  }
  scatter_faces(pair.a, a), scatter_faces(pair.b, b);
}

/// compute_hull_depth() of the pair in each lane. @param pair its vertices are placed
template <class Wide, class Pack>
TOUCHSTONE_INLINE void hull_depth_lanes(const TasksOfLanes<Pack>& tasks, SolidPairLanes<Pack>& pair) {
  // Faces, seen from either.
  pose_faces<Pack>(tasks.hulls_a, pair.a), pose_faces<Pack>(tasks.hulls_b, pair.b);
  look_from_faces(pair.b.vertices, pair.a), look_from_faces(pair.a.vertices, pair.b);
  const FaceAxisLanes<Pack> face = best_face(pair);
  const unsigned apart = bits(face.separation > rounding_of(pair, kHullRoundoffs));
  const unsigned open = ~apart & ((1u << tasks.here) - 1);
  for (std::size_t l = 0; l < tasks.here; ++l) {
    DepthRecord& out = *tasks.of[l]->depth;
    out.certified = open >> l & 1u ? Certified::unknown : Certified::separated;
    out.known = DepthKnown::nothing;
    out.axis = 0;
  }
  if (open == 0) return;
  // Edges that could do better.
  const EdgesOfLanes<Pack> edges(pair, tasks.hulls_a, tasks.hulls_b, -face.separation, open);
  look_at_edges<Pack>(tasks.hulls_a, edges.any_a, tasks.hulls_b, edges.any_b, pair);
  // The rest pair by pair.
  PosedLane posed[Traits<Pack>::lanes];
  write_placed(pair, tasks);
  write_posed(pair, tasks, posed);
  for (unsigned rest = open; rest != 0; rest &= rest - 1) {
    const int l = __builtin_ctz(rest);
    const PosedLane& lane = posed[l];
    const Magnitudes size = {pair.extent[l], pair.position[l]};
    HullAxis best{face.separation[l], {face.n.x[l], face.n.y[l], face.n.z[l]}};
    (face.of_b[l] ? best.face_b : best.face_a) = static_cast<int>(face.face[l]);
    if (search_edges<Wide>(LaneOf<Pack>{pair, l}, lane.A, edges.a[l], lane.B, edges.b[l], size.extent,
                           best) == EdgeSearch::done)
      settle_depth<Wide>(lane.A, lane.B, best, size, *tasks.of[l]->depth);
  }
}

TOUCHSTONE_INLINE void prefetch_hull(const HullRecord& hull) {
  const char* const record = (const char*)&hull;
  for (std::size_t line = 0; line < __builtin_offsetof(HullRecord, normals[1]); line += 64)
    __builtin_prefetch(record + line);
  for (std::size_t line = 0; line < kLaneEdges * sizeof(HullEdge); line += 64)
    __builtin_prefetch((const char*)hull.edges + line);
}

template <class Wide, class Pack>
TOUCHSTONE_INLINE void compute_hull_depths_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                                  const HullTask* tasks, std::size_t count) {
  constexpr std::size_t kLanes = Traits<Pack>::lanes;
  for (std::size_t first = 0; first < count; first += kLanes) {
    // Those after these are fetched meanwhile.
    for (std::size_t i = first + kLanes; i < first + 2 * kLanes && i < count; ++i) {
      prefetch(poses, shapes, tasks[i].pair.a), prefetch(poses, shapes, tasks[i].pair.b);
      prefetch_hull(*tasks[i].a), prefetch_hull(*tasks[i].b);
    }
    const TasksOfLanes<Pack> lanes(tasks + first, count - first);
    SolidPairLanes<Pack> pair;
    place_tasks(poses, shapes, lanes, pair);
    hull_depth_lanes<Wide>(lanes, pair);
  }
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
