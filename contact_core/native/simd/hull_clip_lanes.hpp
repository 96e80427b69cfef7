#pragma once

#include "touchstone/contact_core/native/simd/hull_distance_kernels.hpp"
#include "touchstone/contact_core/native/simd/manifold_kernels.hpp"

// Manifolds of general hexahedra, pairs in lanes: make_manifold()'s choice and clip of two contact faces,
// where both solids have six plane quadrangles. Every number results from the same operations in the same
// order as in polygon_clip.hpp, so the bits are the same; which corners are left, and in which order, is
// scalar code's.
//
// Pairs that fit: one face of each leans least by more than rounding, none is steep, no corner sharp.

namespace touchstone::native::TOUCHSTONE_ISA {

/// A face projected along n: FacePolygon<4>, its corners counter-clockwise seen against n.
template <class Pack>
struct QuadLanes {
  Vector3Of<Pack> p[4];
  Pack x[4], y[4];
  Pack edge_x[4], edge_y[4], length2[4];
};

/// The contact face of a solid.
template <class Pack>
struct PlainFaceLanes {
  QuadLanes<Pack> quad;
  Vector3Of<Pack> normal, anchor;
  Pack inverse;         // 1 / normal . n
  MaskOf<Pack> number;  // of kQuads
  MaskOf<Pack> fits;
};

/// find_contact_faces() of one of the solids, A's for kIsB false.
template <bool kIsB, class Pack>
TOUCHSTONE_INLINE void choose_plain_face(const double* const (&hulls)[Traits<Pack>::lanes],
                                         const Vector3Of<Pack> (&column)[3], const Vector3Of<Pack>& n,
                                         const VertexLanes<Pack>& v, PlainFaceLanes<Pack>& out) {
  using Mask = MaskOf<Pack>;
  // n and the normals in the solid's frame.
  Pack local[20];
  gather(hulls, local);
  Vector3Of<Pack> N[3];
  for (int i = 0; i < 3; ++i) N[i] = cross(column[(i + 1) % 3], column[(i + 2) % 3]);
  const auto along = [&](int c) { return kIsB ? -dot(N[c], n) : dot(N[c], n); };
  const Vector3Of<Pack> n_S = {along(0), along(1), along(2)};
  // The face that looks most along n, and how much the next one does.
  Pack best{}, second = all<Pack>(-1.0);
  Vector3Of<Pack> normal{};
  out.number = Mask{};
  for (int f = 0; f < 6; ++f) {
    const Vector3Of<Pack> of_face = {local[f], local[6 + f], local[12 + f]};
    const Pack lean = dot(of_face, n_S);
    const auto corner = [f](int k) { return int{kQuads[f][kIsB ? 3 - k : k]}; };
    if (f == 0) {
      best = lean, normal = of_face;
      for (int k = 0; k < 4; ++k) out.quad.p[k] = vertex_of(v, corner(k));
      continue;
    }
    const Mask further = lean > best;
    second = greatest(least(lean, best), second);
    best = select(further, lean, best);
    normal = select(further, of_face, normal);
    out.number = (further & (Mask{} + f)) | (~further & out.number);
    for (int k = 0; k < 4; ++k) out.quad.p[k] = select(further, vertex_of(v, corner(k)), out.quad.p[k]);
  }
  out.fits = (best > second + all<Pack>(hull_clip::kSameLean)) & (best >= all<Pack>(hull_clip::kSteep));
  out.normal = rotate(N, normal);
  out.inverse = all<Pack>(kIsB ? -1.0 : 1.0) / best;
  out.anchor = out.quad.p[kIsB ? 3 : 0];
}

/// project_plain(). @return where no corner is sharp
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> project_quad(const PlaneAcross<Pack>& across, QuadLanes<Pack>& quad) {
  for (int i = 0; i < 4; ++i) {
    const Vector2Of<Pack> p = across.of(quad.p[i]);
    quad.x[i] = p.x, quad.y[i] = p.y;
  }
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    quad.edge_x[i] = quad.x[j] - quad.x[i], quad.edge_y[i] = quad.y[j] - quad.y[i];
    quad.length2[i] = quad.edge_x[i] * quad.edge_x[i] + quad.edge_y[i] * quad.edge_y[i];
  }
  MaskOf<Pack> blunt = ~MaskOf<Pack>{};
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    const Pack turn = quad.edge_x[i] * quad.edge_y[j] - quad.edge_y[i] * quad.edge_x[j];
    const Pack least2 =
        all<Pack>(hull_clip::kSharp * hull_clip::kSharp) * (quad.length2[i] * quad.length2[j]);
    blunt &= (turn > Pack{}) & (turn * turn > least2);
  }
  return blunt;
}

/// What edges that are parallel, or nearly so, need.
template <class Pack>
struct ParallelLanes {
  Pack tolerance;
  MaskOf<Pack> any;  // lanes that have such edges
};

/// is_aligned()
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> is_aligned(Pack length4, Pack r) {
  return (all<Pack>(kFlushEdges * kFlushEdges) * length4) * (r * r) >= all<Pack>(1.0);
}

/// cut(). @param r [edge of B][edge of A]
template <bool kOfA, bool kAnyParallel, class Pack>
TOUCHSTONE_INLINE FourParts<Pack> cut_quad(const QuadLanes<Pack>& edges, const QuadLanes<Pack>& lines,
                                           const Pack (&r)[4][4], const ParallelLanes<Pack>& parallel) {
  using Mask = MaskOf<Pack>;
  const Pack zero{}, one = all<Pack>(1.0);
  // Every edge begins whole, and each line of the other face cuts it.
  FourParts<Pack> out;
  for (int i = 0; i < 4; ++i) out.from[i] = zero, out.to[i] = one;
  for (int k = 0; k < 4; ++k) {
    const Pack ex = lines.edge_x[k], ey = lines.edge_y[k];
    const Pack lx = kOfA ? ex : -ex, ly = kOfA ? ey : -ey;
    for (int i = 0; i < 4; ++i) {
      const Pack crossing = kOfA ? r[k][i] : r[i][k];
      Pack side = lx * (edges.y[i] - lines.y[k]) - ly * (edges.x[i] - lines.x[k]);
      // Rounding decides the side of edges along a line, so these get slack.
      if constexpr (kAnyParallel) {
        const Pack slack = parallel.tolerance * (magnitude(ex) + magnitude(ey));
        const Pack part = slack * crossing;
        const Mask aligned = is_aligned<Pack>(edges.length2[i] * lines.length2[k], crossing);
        const Mask is_parallel = part * part > all<Pack>(hull_clip::kParallel * hull_clip::kParallel);
        const Pack of_parallel = select(is_parallel, slack, zero);
        const Pack moved = side + select(aligned, kOfA ? slack : -slack, of_parallel);
        side = select(parallel.any, moved, side);
      }
      // The part inside runs from the last entry to the first exit.
      const Pack t = side * crossing;
      const Mask enters = kOfA ? crossing < zero : crossing >= zero;
      out.from[i] = greatest(select(enters, t, zero), out.from[i]);
      out.to[i] = least(select(enters, one, t), out.to[i]);
    }
  }
  return out;
}

/// join_flush_edges(): bit 4 j + i where A's edge i and B's j are flush.
template <class Pack>
TOUCHSTONE_INLINE MaskOf<Pack> flush_edges(const QuadLanes<Pack>& a, const QuadLanes<Pack>& b,
                                           const Pack (&r)[4][4], Pack tolerance) {
  const Pack zero{}, half = all<Pack>(0.5), quarter2 = all<Pack>(0.25 * kFlushEdges * kFlushEdges);
  LaneBits<Pack> out;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const Pack ax = a.edge_x[i], ay = a.edge_y[i], bx = b.edge_x[j], by = b.edge_y[j];
      const Pack a2 = a.length2[i], b2 = b.length2[j];
      const Pack x = (a.x[i] + half * ax) - b.x[j], y = (a.y[i] + half * ay) - b.y[j];
      const Pack side = bx * y - by * x, shorter2 = least(a2, b2);
      const Pack near2 = quarter2 * shorter2 + all<Pack>(16.0) * (tolerance * tolerance);
      out.add(is_aligned<Pack>(a2 * b2, r[j][i]) & (ax * bx + ay * by > zero) & (side * side <= near2 * b2),
              4 * j + i);
    }
  }
  return out.words;
}

/// The tasks of the lanes; those beyond the last repeat it.
template <class Pack>
struct ClipsOfLanes {
  static constexpr std::size_t kLanes = Traits<Pack>::lanes;

  const double *hulls_a[kLanes], *hulls_b[kLanes], *n_separation[kLanes];
  PairIndices pair[kLanes];
  HullClipRecord* out[kLanes];

  TOUCHSTONE_INLINE ClipsOfLanes(const HullClipTask* tasks, std::size_t left, HullClipRecord* records) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const std::size_t i = l < left ? l : left - 1;
      hulls_a[l] = tasks[i].a->normals[0], hulls_b[l] = tasks[i].b->normals[0];
      n_separation[l] = tasks[i].n_separation;
      pair[l] = tasks[i].pair;
      out[l] = records + i;
    }
  }
};

/// Places the corners on one face's edges, as place() in polygon_clip.hpp.
template <bool kIsB, class Pack>
TOUCHSTONE_INLINE void place_corners(const QuadLanes<Pack>& quad, const FourParts<Pack>& parts,
                                     const PlainFaceLanes<Pack>& other, Pack least_separation, Pack limit,
                                     Pack shortest2, const ClipsOfLanes<Pack>& tasks, LaneBits<Pack>& left) {
  constexpr int kFirst = kIsB ? 4 : 0;
  // The corners, how far the other face is there, and which are left.
  const Pack steepness = kIsB ? -other.inverse : other.inverse;
  Vector3Of<Pack> p[4];
  Pack separation[4];
  for (int i = 0; i < 4; ++i) {
    const Vector3Of<Pack>&from = quad.p[i], &to = quad.p[(i + 1) % 4];
    p[i] = from + parts.from[i] * (to - from);
    const Pack height = dot(other.normal, other.anchor - p[i]) * steepness;
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    separation[i] = greatest(height, least_separation);
    const Pack part = parts.to[i] - parts.from[i];
    const MaskOf<Pack> is_left = (part > Pack{}) & (part * part * quad.length2[i] > shortest2);
    left.add(is_left, HullClipBits::kLeft + kFirst + i);
    left.add(is_left & (separation[i] <= limit), HullClipBits::kNear + kFirst + i);
  }
  // To each lane's record.
  double *x[Traits<Pack>::lanes], *y[Traits<Pack>::lanes], *z[Traits<Pack>::lanes], *s[Traits<Pack>::lanes];
  for (int l = 0; l < Traits<Pack>::lanes; ++l) {
    HullClipRecord& record = *tasks.out[l];
    x[l] = record.p_x + kFirst, y[l] = record.p_y + kFirst, z[l] = record.p_z + kFirst;
    s[l] = record.separation + kFirst;
  }
  const Pack px[4] = {p[0].x, p[1].x, p[2].x, p[3].x}, py[4] = {p[0].y, p[1].y, p[2].y, p[3].y},
             pz[4] = {p[0].z, p[1].z, p[2].z, p[3].z};
  scatter(px, x), scatter(py, y), scatter(pz, z), scatter(separation, s);
}

/// Both solids about A's first vertex, and their contact faces.
template <class Pack>
struct FacesOfLanes {
  Vector3Of<Pack> n, origin;
  Pack separation, extent;
  PlainFaceLanes<Pack> a, b;
  MaskOf<Pack> fits;
};

template <class Pack>
TOUCHSTONE_INLINE void place_faces(const PoseRecord* poses, const VertexRecord* shapes,
                                   const ClipsOfLanes<Pack>& tasks, FacesOfLanes<Pack>& out) {
  constexpr int kLanes = Traits<Pack>::lanes;
  const double *poses_a[kLanes], *poses_b[kLanes], *shapes_a[kLanes], *shapes_b[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    poses_a[l] = poses[tasks.pair[l].a].R, poses_b[l] = poses[tasks.pair[l].b].R;
    shapes_a[l] = shapes[tasks.pair[l].a].x, shapes_b[l] = shapes[tasks.pair[l].b].x;
  }
  // The vertices.
  const PoseLanes<Pack> X_WA = gather_poses<Pack>(poses_a), X_WB = gather_poses<Pack>(poses_b);
  VertexLanes<Pack> v_a, v_b;
  Pack reach{}, n_separation[4];
  place_vertices<Pack>(shapes_a, X_WA, &X_WA.p, reach, v_a);
  place_vertices<Pack>(shapes_b, X_WB, &X_WB.p, reach, v_b);
  out.origin = vertex_of(v_a, 0);
  out.extent = Pack{};
  shift(out.origin, v_a, out.extent), shift(out.origin, v_b, out.extent);
  // The faces, seen along n.
  gather(tasks.n_separation, n_separation);
  out.n = {n_separation[0], n_separation[1], n_separation[2]};
  out.separation = n_separation[3];
  choose_plain_face<false>(tasks.hulls_a, X_WA.column, out.n, v_a, out.a);
  choose_plain_face<true>(tasks.hulls_b, X_WB.column, out.n, v_b, out.b);
  const PlaneAcross<Pack> across(out.n, with_sign_of(all<Pack>(1.0), out.n.z));
  out.fits = out.a.fits & out.b.fits;
  out.fits &= project_quad(across, out.a.quad);
  out.fits &= project_quad(across, out.b.quad);
}

/// The parts of both faces' edges that are left. @param flush see flush_edges()
template <class Pack>
TOUCHSTONE_INLINE void cut_faces(const FacesOfLanes<Pack>& faces, FourParts<Pack>& of_a,
                                 FourParts<Pack>& of_b, MaskOf<Pack>& flush, LaneBits<Pack>& words) {
  const QuadLanes<Pack>&a = faces.a.quad, &b = faces.b.quad;
  const Pack tolerance = all<Pack>(hull_clip::kCoincide * kU) * faces.extent;
  const Pack bound = all<Pack>(hull_clip::kNearlyParallel) / (tolerance * (all<Pack>(8.0) * faces.extent));
  // Where each edge of A crosses each of B.
  Pack r[4][4], steepest{};
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const Pack turn = a.edge_x[i] * b.edge_y[j] - a.edge_y[i] * b.edge_x[j];
      r[j][i] = all<Pack>(1.0) / (turn + Pack{});
      steepest = greatest(magnitude(r[j][i]), steepest);
      words.add(r[j][i] < Pack{}, HullClipBits::kBehind + 4 * j + i);
    }
  }
  // Few pairs have edges that are nearly parallel.
  const ParallelLanes<Pack> parallel = {tolerance, steepest > bound};
  flush = MaskOf<Pack>{};
  if (bits(parallel.any) != 0) {
    of_a = cut_quad<true, true>(a, b, r, parallel);
    of_b = cut_quad<false, true>(b, a, r, parallel);
    flush = flush_edges(a, b, r, tolerance) & parallel.any;
  } else {
    of_a = cut_quad<true, false>(a, b, r, parallel);
    of_b = cut_quad<false, false>(b, a, r, parallel);
  }
}

template <class Pack>
TOUCHSTONE_INLINE void clip_hulls_lanes(const PoseRecord* poses, const VertexRecord* shapes,
                                        const ClipsOfLanes<Pack>& tasks, double max_point_separation) {
  constexpr int kLanes = Traits<Pack>::lanes;
  // The faces, and what is left of their edges.
  FacesOfLanes<Pack> faces;
  place_faces(poses, shapes, tasks, faces);
  LaneBits<Pack> words;
  FourParts<Pack> of_a, of_b;
  MaskOf<Pack> flush;
  cut_faces(faces, of_a, of_b, flush, words);
  // The corners.
  const Pack tie = all<Pack>(hull_clip::kAsDeep * kU) * faces.extent;
  const Pack limit = greatest(all<Pack>(max_point_separation), faces.separation + tie);
  const Pack shortest = all<Pack>(hull_clip::kShortest) * faces.extent, shortest2 = shortest * shortest;
  place_corners<false>(faces.a.quad, of_a, faces.b, faces.separation, limit, shortest2, tasks, words);
  place_corners<true>(faces.b.quad, of_b, faces.a, faces.separation, limit, shortest2, tasks, words);
  words.add(faces.fits, HullClipBits::kFits);
  words.words |= (faces.a.number << HullClipBits::kFaceA) | (faces.b.number << HullClipBits::kFaceB);
  // The rest of the records.
  double* rest[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    HullClipRecord& record = *tasks.out[l];
    record.bits = static_cast<std::uint64_t>(words.words[l]);
    record.flush = static_cast<std::uint64_t>(flush[l]);
    rest[l] = record.origin;
  }
  static_assert(__builtin_offsetof(HullClipRecord, tie) ==
                __builtin_offsetof(HullClipRecord, origin) + 3 * sizeof(double));
  const Pack placed[4] = {faces.origin.x, faces.origin.y, faces.origin.z, tie};
  scatter(placed, rest);
}

TOUCHSTONE_INLINE void prefetch_plain(const PlainHull& hull) {
  for (std::size_t line = 0; line < sizeof hull.normals; line += 64)
    __builtin_prefetch((const char*)&hull + line);
}

template <class Pack>
TOUCHSTONE_INLINE void clip_hulls_inline(const PoseRecord* poses, const VertexRecord* shapes,
                                         const HullClipTask* tasks, std::size_t count,
                                         double max_point_separation, HullClipRecord* out) {
  constexpr std::size_t kLanes = Traits<Pack>::lanes;
  for (std::size_t first = 0; first < count; first += kLanes) {
    // Those after these are fetched meanwhile.
    for (std::size_t i = first + kLanes; i < first + 2 * kLanes && i < count; ++i) {
      prefetch(poses, shapes, tasks[i].pair.a), prefetch(poses, shapes, tasks[i].pair.b);
      prefetch_plain(*tasks[i].a), prefetch_plain(*tasks[i].b);
    }
    clip_hulls_lanes<Pack>(poses, shapes, ClipsOfLanes<Pack>(tasks + first, count - first, out + first),
                           max_point_separation);
  }
}

}  // namespace touchstone::native::TOUCHSTONE_ISA
