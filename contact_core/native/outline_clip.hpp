#pragma once

#include <bit>

#include "contact_core/native/outline.hpp"

namespace touchstone::native {

/// The corners of the region common to two outlines, counter-clockwise, unsorted: each is the point where the
/// region's boundary turns onto an edge. Edges 0 to N - 1 are A's, N to 2 N - 1 are B's.
template <int N>
struct Clip {
  int count = 0;
  std::array<std::uint8_t, 2 * N> edge;  ///< of the corners, in order
  /// By edge: the corner, on that edge of its solid, and how far the other solid's plane is from there along
  /// n, negative inside.
  alignas(16) std::array<double, 2 * N> p_x, p_y, p_z, separation;
};

/// Clips each edge of either outline against the lines of all edges of the other (Cyrus, Beck 1978), which
/// needs no branches; what is left of the edges, in the order of their directions, is the common region's
/// boundary. Where edges coincide to `tolerance` A's counts. Edges left with no more than `shortest` are
/// dropped.
///
/// Each half's own error does not add up: a corner lies on its own edge by construction and within tolerance
/// and rounding of the lines that cut it.
template <int N>
void clip(const Outline<N>& a, const Outline<N>& b, const Vector3& n, const Facing& plane_a,
          const Facing& plane_b, double tolerance, double shortest, Clip<N>& out);

// ---- implementation

namespace clip_detail {

/// Edges are parallel to rounding when moving one across by the tolerance moves their crossing by more than this
/// part of the other.
constexpr double kParallel = 0x1p-20;

inline Double2 splat(double x) { return Double2{x, x}; }

/// Bit i: p[i] < 0; p holds no -0.
template <int N>
unsigned negative(const Row<N>& p) {
  unsigned mask = 0;
#ifdef __SSE2__
  for (int i = 0; i < N / 2; ++i) mask |= static_cast<unsigned>(__builtin_ia32_movmskpd(p.d[i])) << (2 * i);
#else
  for (int i = 0; i < N; ++i) mask |= static_cast<unsigned>(p[i] < 0.0) << i;
#endif
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
  Row<N> missing;
  for (int i = 0; i < N / 2; ++i) {
    const Double2 part = parts.to.d[i] - parts.from.d[i];
    const auto is_left = (part > 0.0) & (part * part * length2.d[i] > shortest * shortest);
    missing.d[i] = is_left ? splat(-1.0) : splat(1.0);
  }
  return negative(missing);
}

/// The other outline's lines cut `edges`: line k by the rows lines.x[k] and so on; r[k] = 1 / cross(edge of A,
/// edge of B). Sign is +1 for A's edges, -1 for B's. An edge parallel to a line (r infinite, or NaN times 0)
/// is left whole when its start is inside.
template <int N, bool kOfA>
Parts<N> cut(const Outline<N>& edges, const Outline<N>& lines, const std::array<Row<N>, N>& r,
             double tolerance) {
  Parts<N> out;
  for (int i = 0; i < N / 2; ++i) out.from.d[i] = splat(0.0), out.to.d[i] = splat(1.0);
  for (int k = 0; k < N; ++k) {
    const double ex = lines.edge_x[k], ey = lines.edge_y[k];
    const Double2 lx = splat(ex), ly = splat(ey), x = splat(lines.x[k]), y = splat(lines.y[k]);
    const Double2 slack = splat((kOfA ? tolerance : -tolerance) * (std::abs(ex) + std::abs(ey)));
    for (int i = 0; i < N / 2; ++i) {
      Double2 side = lx * (edges.y.d[i] - y) - ly * (edges.x.d[i] - x);
      const Double2 part = slack * r[k].d[i];
      side += part * part > kParallel * kParallel ? slack : splat(0.0);
      const Double2 t = kOfA ? side * r[k].d[i] : -side * r[k].d[i];
      const auto enters = kOfA ? r[k].d[i] < 0.0 : r[k].d[i] >= 0.0;
      const Double2 in = enters ? t : splat(0.0), leaving = enters ? splat(1.0) : t;
      out.from.d[i] = greatest(in, out.from.d[i]);
      out.to.d[i] = least(leaving, out.to.d[i]);
    }
  }
  return out;
}

/// The corners on the edges, and how far the other solid's plane is from them.
template <int N>
void place(const Outline<N>& edges, const Row<N>& from, const Vector3& n, const Facing& plane, double sign,
           int first, Clip<N>& out) {
  const Double2 nx = splat(plane.normal.x()), ny = splat(plane.normal.y()), nz = splat(plane.normal.z());
  const Double2 qx = splat(plane.anchor.x()), qy = splat(plane.anchor.y()), qz = splat(plane.anchor.z());
  const Double2 scale = splat(sign * plane.inverse);
  static_cast<void>(n);
  for (int i = 0; i < N / 2; ++i) {
    const int j = (i + 1) % (N / 2);
    const Double2 x = edges.p_x.d[i], y = edges.p_y.d[i], z = edges.p_z.d[i], t = from.d[i];
    const Double2 px = x + t * (__builtin_shufflevector(x, edges.p_x.d[j], 1, 2) - x);
    const Double2 py = y + t * (__builtin_shufflevector(y, edges.p_y.d[j], 1, 2) - y);
    const Double2 pz = z + t * (__builtin_shufflevector(z, edges.p_z.d[j], 1, 2) - z);
    const Double2 s = ((nx * (qx - px) + ny * (qy - py)) + nz * (qz - pz)) * scale;
    for (int k = 0; k < 2; ++k) {
      const int to = first + 2 * i + k;
      out.p_x[to] = px[k], out.p_y[to] = py[k], out.p_z[to] = pz[k], out.separation[to] = s[k];
    }
  }
}

/// One bit an edge, in the order of directions from A's edge 0 on: A's edge i opens group i, B's edges whose
/// directions lie between it and A's next follow.
template <int N>
struct Order {
  static constexpr int kGroup = 2 * N;
  static constexpr int kWords = (N * kGroup + 63) / 64;

  std::array<std::uint64_t, kWords> words{};
  int first_b = 0;  ///< B's edge that comes first
  int count_b = N;

  void add(int position) { words[position / 64] |= std::uint64_t{1} << (position % 64); }
  int edge_at(int position) const {
    const int group = position / kGroup, place = position % kGroup;
    if (place == 0) return group;
    const int j = first_b + place - 1;
    return N + (j < count_b ? j : j - count_b);
  }
};

template <int N>
Order<N> order(int count_b, const std::array<Row<N>, N>& r, unsigned left_a, unsigned left_b) {
  Order<N> out;
  out.count_b = count_b;
  std::array<int, N> group{};
  for (int j = 0; j < count_b; ++j) {
    const unsigned behind = negative(r[j]);  // A's edges whose direction is past B's edge j
    const unsigned last = ~behind & (behind >> 1 | behind << (N - 1)) & ((1u << N) - 1);
    group[j] = std::countr_zero(last | 1u << (N - 1));
  }
  for (int j = count_b - 1; j >= 0; --j)
    if (group[j > 0 ? j - 1 : count_b - 1] > group[j]) out.first_b = j;
  for (int i = 0; i < N; ++i)
    out.words[i * Order<N>::kGroup / 64] |= std::uint64_t{left_a >> i & 1u} << (i * Order<N>::kGroup % 64);
  for (int j = 0; j < count_b; ++j) {
    const int place = 1 + (j >= out.first_b ? j - out.first_b : j - out.first_b + count_b);
    const int position = group[j] * Order<N>::kGroup + place;
    out.words[position / 64] |= std::uint64_t{left_b >> j & 1u} << (position % 64);
  }
  return out;
}

}  // namespace clip_detail

template <int N>
void clip(const Outline<N>& a, const Outline<N>& b, const Vector3& n, const Facing& plane_a,
          const Facing& plane_b, double tolerance, double shortest, Clip<N>& out) {
  using namespace clip_detail;
  std::array<Row<N>, N> r, r_transposed;
  for (int j = 0; j < N; ++j) {
    const Double2 ex = splat(b.edge_x[j]), ey = splat(b.edge_y[j]);
    for (int i = 0; i < N / 2; ++i) {
      // + 0 makes -0 a 0.
      const Double2 across = (a.edge_x.d[i] * ey - a.edge_y.d[i] * ex) + 0.0;
      r[j].d[i] = 1.0 / across;
    }
  }
  transpose<N>(r, r_transposed);
  const Parts<N> of_a = cut<N, true>(a, b, r, tolerance), of_b = cut<N, false>(b, a, r_transposed, tolerance);
  place<N>(a, of_a.from, n, plane_b, 1.0, 0, out);
  place<N>(b, of_b.from, n, plane_a, -1.0, N, out);
  const Order<N> ordered = order<N>(b.count, r, longer(of_a, a.length2, shortest), longer(of_b, b.length2, shortest));
  out.count = 0;
  for (int w = 0; w < Order<N>::kWords; ++w)
    for (std::uint64_t word = ordered.words[w]; word != 0; word &= word - 1)
      out.edge[out.count++] = static_cast<std::uint8_t>(ordered.edge_at(64 * w + std::countr_zero(word)));
}

}  // namespace touchstone::native
