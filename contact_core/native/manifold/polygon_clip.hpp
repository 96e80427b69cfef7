#pragma once

#include <bit>

#include "touchstone/contact_core/native/manifold/face_polygon.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

namespace touchstone::native {

/// One bit for each edge, in the order of directions from A's edge 0 on: A's edge i opens group i, B's edges
/// whose directions lie between it and A's next follow.
template <int N>
struct Order {
  static constexpr int kGroup = 2 * N;
  static constexpr int kWords = (N * kGroup + 63) / 64;

  std::array<std::uint64_t, kWords> words{};
  int first_b = 0;  ///< B's edge that comes first
  int count_b = N;

  void add(int position, std::uint64_t bit) { words[position / 64] |= bit << (position % 64); }
  int edge_at(int position) const {
    const int group = position / kGroup, place = position % kGroup;
    const int j = first_b + place - 1, of_b = N + (j < count_b ? j : j - count_b);
    return place == 0 ? group : of_b;
  }
};

/// The corners of the intersection of two polygons, counter-clockwise. Each lies on the edge that the
/// boundary turns onto there: 0 to N - 1 are A's edges, N to 2 N - 1 B's.
template <int N>
struct Clip {
  Order<N> order;  ///< the edges that have a corner
  /// By edge: the corner, the distance of the other solid's face along n (negative: inside), and the label of
  /// its face's edge.
  alignas(16) std::array<double, 2 * N> p_x, p_y, p_z, separation;
  std::array<std::uint8_t, 2 * N> label;
};

/// Calls visit(edge) for each corner in order.
template <int N, class Visit>
void visit_corners(const Order<N>& order, const Visit& visit) {
  for (int w = 0; w < Order<N>::kWords; ++w)
    for (std::uint64_t word = order.words[w]; word != 0; word &= word - 1)
      visit(order.edge_at(64 * w + std::countr_zero(word)));
}

/// The edge of the last corner; any edge when there is none.
template <int N>
int last_corner(const Order<N>& order) {
  for (int w = Order<N>::kWords - 1; w > 0; --w)
    if (order.words[w] != 0) return order.edge_at(64 * w + 63 - std::countl_zero(order.words[w]));
  return order.edge_at(63 - std::countl_zero(order.words[0] | 1u));
}

/// @param behind of each of B's edges: bits of A's edges that turn past it. @param left_a, left_b bits of the
/// edges that have a corner
template <int N>
Order<N> order_edges(int count_b, const std::array<unsigned, N>& behind, unsigned left_a, unsigned left_b);

/// Clips each edge of either polygon against the lines of all edges of the other (Cyrus, Beck 1978), which
/// needs no branches; the remaining parts of the edges, in the order of their directions, bound the
/// intersection. Where edges coincide to kCoincide u * extent A's count; flush edges (kFlushEdges) go by A's
/// label. Edges left no longer than kShortest * extent are dropped. A corner lies on its own edge by
/// construction, and within rounding of the lines that cut it.
/// @param extent at least every |coordinate|
template <int N>
void clip(const FacePolygon<N>& a, const FacePolygon<N>& b, const ContactFace& face_a,
          const ContactFace& face_b, double extent, Clip<N>& out);

// ---- implementation

namespace clip_detail {

using hull_clip::kCoincide, hull_clip::kNearlyParallel, hull_clip::kParallel, hull_clip::kShortest;

/// Bit i: p[i] < 0.
template <int N>
unsigned negative(const Row<N>& p) {
  unsigned mask = 0;
  for (int i = 0; i < N / 2; ++i) mask |= bits(p.d[i] < 0.0) << (2 * i);
  return mask;
}

/// r[j] over i to out[i] over j.
template <int N>
void transpose(const std::array<Row<N>, N>& r, std::array<Row<N>, N>& out) {
  for (int j = 0; j < N / 2; ++j) {
    for (int i = 0; i < N / 2; ++i) {
      const Double2 u = r[2 * j].d[i], v = r[2 * j + 1].d[i];
      out[2 * i].d[j] = __builtin_shufflevector(u, v, 0, 2);
      out[2 * i + 1].d[j] = __builtin_shufflevector(u, v, 1, 3);
    }
  }
}

/// The parts [from, to] of the edges that are left; nothing when from >= to.
template <int N>
struct Parts {
  Row<N> from, to;
};

/// Bit i: edge i has more than `shortest` left.
template <int N>
unsigned longer(const Parts<N>& parts, const Row<N>& length2, double shortest) {
  const Double2 least2 = all<Double2>(shortest * shortest);
  unsigned mask = 0;
  for (int i = 0; i < N / 2; ++i) {
    const Double2 part = parts.to.d[i] - parts.from.d[i];
    mask |= bits((part > 0.0) & (part * part * length2.d[i] > least2)) << (2 * i);
  }
  return mask;
}

/// Whether some edge of A is parallel to one of B to rounding, or nearly so. `reach` bounds the edges'
/// lengths.
template <int N>
bool any_parallel(const std::array<Row<N>, N>& r, double tolerance, double reach) {
  Double2 low = all<Double2>(0.0), high = all<Double2>(0.0);
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < N / 2; ++i) low = least(r[j].d[i], low), high = greatest(r[j].d[i], high);
  const Double2 bound = all<Double2>(kNearlyParallel / (tolerance * reach));
  return bits((high > bound) | (low < -bound)) != 0;
}

/// 1 where edges lie at an angle of no more than kFlushEdges to each other. @param length4 the product of
/// their squared lengths; 0 (bevels) has no direction.
inline Double2 is_aligned(Double2 length4, Double2 r) {
  return (kFlushEdges * kFlushEdges * length4) * (r * r) >= 1.0 ? all<Double2>(1.0) : all<Double2>(0.0);
}

/// Gives each of B's edges that is flush with one of A's the label of that one; the reverse where swapped.
template <int N>
void join_flush_edges(const FacePolygon<N>& a, const FacePolygon<N>& b, const std::array<Row<N>, N>& r,
                      double tolerance, bool swapped, Clip<N>& out) {
  for (int j = 0; j < b.count; ++j) {
    for (int i = 0; i < a.count; ++i) {
      const double ax = a.edge_x[i], ay = a.edge_y[i], bx = b.edge_x[j], by = b.edge_y[j];
      const double a2 = a.length2[i], b2 = b.length2[j];
      if (!(is_aligned(all<Double2>(a2 * b2), all<Double2>(r[j][i]))[0] > 0.0) || !(ax * bx + ay * by > 0.0))
        continue;
      const double x = (a.x[i] + 0.5 * ax) - b.x[j], y = (a.y[i] + 0.5 * ay) - b.y[j];
      const double side = bx * y - by * x, shorter2 = a2 < b2 ? a2 : b2;
      const double near2 = 0.25 * kFlushEdges * kFlushEdges * shorter2 + 16.0 * (tolerance * tolerance);
      if (!(side * side <= near2 * b2)) continue;
      if (swapped)
        out.label[i] = b.label[j];
      else
        out.label[N + j] = a.label[i];
    }
  }
}

/// Cuts `edges` by the other polygon's lines. r[k] = 1 / cross(edge of A, edge of B) for the other's edge k.
/// A's edges (kOfA) that are parallel to a line to rounding are kept when no more than `tolerance` outside,
/// B's too where the two may count as one, else only when more than that inside. (Where r is infinite, t is
/// infinite or NaN, and from and to stay or cross.)
template <int N, bool kOfA, bool kAnyParallel>
Parts<N> cut(const FacePolygon<N>& edges, const FacePolygon<N>& lines, const std::array<Row<N>, N>& r,
             double tolerance) {
  Parts<N> out;
  // Every edge begins whole, and each line of the other face cuts it.
  for (int i = 0; i < N / 2; ++i) out.from.d[i] = all<Double2>(0.0), out.to.d[i] = all<Double2>(1.0);
  for (int k = 0; k < N; ++k) {
    const double ex = lines.edge_x[k], ey = lines.edge_y[k];
    const Double2 lx = all<Double2>(kOfA ? ex : -ex), ly = all<Double2>(kOfA ? ey : -ey);
    const Double2 x = all<Double2>(lines.x[k]), y = all<Double2>(lines.y[k]);
    for (int i = 0; i < N / 2; ++i) {
      Double2 side = lx * (edges.y.d[i] - y) - ly * (edges.x.d[i] - x);  // A: > 0 inside, B: < 0
      // Rounding decides the side of edges along a line, so these get slack.
      if constexpr (kAnyParallel) {
        const Double2 slack = all<Double2>(tolerance * (std::abs(ex) + std::abs(ey)));
        const Double2 part = slack * r[k].d[i];
        const Double2 aligned = is_aligned(edges.length2.d[i] * all<Double2>(lines.length2[k]), r[k].d[i]);
        const Double2 of_parallel = part * part > kParallel * kParallel ? slack : all<Double2>(0.0);
        side += aligned > 0.0 ? (kOfA ? slack : -slack) : of_parallel;
      }
      // The part inside runs from the last entry to the first exit.
      const Double2 t = side * r[k].d[i];
      const auto enters = kOfA ? r[k].d[i] < 0.0 : r[k].d[i] >= 0.0;
      const Double2 in = enters ? t : all<Double2>(0.0), leaving = enters ? all<Double2>(1.0) : t;
      out.from.d[i] = greatest(in, out.from.d[i]);
      out.to.d[i] = least(leaving, out.to.d[i]);
    }
  }
  return out;
}

/// The distance of the other solid's plane from two corners, along n.
inline Double2 height_over(const FacePlanes::Plane& plane, const Vector3& anchor, double sign, Double2 px,
                           Double2 py, Double2 pz) {
  const Double2 nx = all<Double2>(plane.normal.x()), ny = all<Double2>(plane.normal.y()),
                nz = all<Double2>(plane.normal.z());
  const Double2 qx = all<Double2>(anchor.x()), qy = all<Double2>(anchor.y()), qz = all<Double2>(anchor.z());
  return ((nx * (qx - px) + ny * (qy - py)) + nz * (qz - pz)) * all<Double2>(sign * plane.inverse);
}

/// Places the corners on the edges and computes the other solid's distance from them. A bent face's solid
/// lies behind both of its planes, so that the one further along n is its surface.
template <int N>
void place(const FacePolygon<N>& edges, const Row<N>& from, const FacePlanes& planes, double sign, int first,
           Clip<N>& out) {
  for (int i = 0; i < N / 2; ++i) {
    const int j = (i + 1) % (N / 2), to = first + 2 * i;
    const Double2 x = edges.p_x.d[i], y = edges.p_y.d[i], z = edges.p_z.d[i], t = from.d[i];
    const Double2 px = x + t * (__builtin_shufflevector(x, edges.p_x.d[j], 1, 2) - x);
    const Double2 py = y + t * (__builtin_shufflevector(y, edges.p_y.d[j], 1, 2) - y);
    const Double2 pz = z + t * (__builtin_shufflevector(z, edges.p_z.d[j], 1, 2) - z);
    store(px, &out.p_x[to]), store(py, &out.p_y[to]), store(pz, &out.p_z[to]);
    Double2 separation = height_over(planes.of[0], planes.anchor, sign, px, py, pz);
    if (planes.count == 2)
      separation = greatest(height_over(planes.of[1], planes.anchor, sign, px, py, pz), separation);
    store(separation, &out.separation[to]);
  }
  for (int i = 0; i < N; ++i) out.label[first + i] = edges.label[i];
}

}  // namespace clip_detail

template <int N>
Order<N> order_edges(int count_b, const std::array<unsigned, N>& behind, unsigned left_a, unsigned left_b) {
  Order<N> out;
  out.count_b = count_b;
  std::array<int, N> group{};
  for (int j = 0; j < count_b; ++j) {
    const unsigned last = ~behind[j] & (behind[j] >> 1 | behind[j] << (N - 1));
    group[j] = std::countr_zero(last | 1u << (N - 1));
  }
  unsigned falls = 0;  // bit j: the group of B's edge j is below its predecessor's
  for (int j = 0; j < count_b; ++j) falls |= (group[j > 0 ? j - 1 : count_b - 1] > group[j] ? 1u : 0u) << j;
  out.first_b = std::countr_zero(falls | (falls == 0 ? 1u : 0u));
  for (int i = 0; i < N; ++i) out.add(i * Order<N>::kGroup, left_a >> i & 1u);
  for (int j = 0; j < count_b; ++j) {
    const int place = 1 + (j >= out.first_b ? j - out.first_b : j - out.first_b + count_b);
    out.add(group[j] * Order<N>::kGroup + place, left_b >> j & 1u);
  }
  return out;
}

template <int N>
void clip(const FacePolygon<N>& a, const FacePolygon<N>& b, const ContactFace& face_a,
          const ContactFace& face_b, double extent, Clip<N>& out) {
  using namespace clip_detail;
  const double tolerance = kCoincide * kRoundoff * extent, shortest = kShortest * extent;
  std::array<Row<N>, N> r, r_transposed;
  for (int j = 0; j < N; ++j) {
    const Double2 ex = all<Double2>(b.edge_x[j]), ey = all<Double2>(b.edge_y[j]);
    for (int i = 0; i < N / 2; ++i)  // + 0 makes -0 a 0
      r[j].d[i] = 1.0 / ((a.edge_x.d[i] * ey - a.edge_y.d[i] * ex) + 0.0);
  }
  transpose<N>(r, r_transposed);
  Parts<N> of_a, of_b;
  const bool parallel = any_parallel<N>(r, tolerance, 8 * extent);
  if (parallel) {
    of_a = cut<N, true, true>(a, b, r, tolerance);
    of_b = cut<N, false, true>(b, a, r_transposed, tolerance);
  } else {
    of_a = cut<N, true, false>(a, b, r, tolerance);
    of_b = cut<N, false, false>(b, a, r_transposed, tolerance);
  }
  place<N>(a, of_a.from, face_b.planes, 1.0, 0, out);
  place<N>(b, of_b.from, face_a.planes, -1.0, N, out);
  if (parallel) join_flush_edges<N>(a, b, r, tolerance, face_a.swapped, out);
  // A constant four where N is 4, so that the loop over B's edges is unrolled.
  const int count_b = N == 4 ? 4 : b.count;
  std::array<unsigned, N> behind{};
  for (int j = 0; j < count_b; ++j) behind[j] = negative(r[j]);
  out.order =
      order_edges<N>(count_b, behind, longer(of_a, a.length2, shortest), longer(of_b, b.length2, shortest));
}

}  // namespace touchstone::native
