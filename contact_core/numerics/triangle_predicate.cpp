#include "touchstone/contact_core/numerics/triangle_predicate.hpp"

#include <bit>
#include <optional>
#include <utility>

namespace touchstone::numerics {
namespace {

using Difference = DifferenceDeterminant::Difference;

constexpr int kFirstOfB = ExactPair::kFirstOfB;

/// Whether the origin is in a tetrahedron on a given triangle of W. For any four vectors
/// d0 w0 + d1 w1 + d2 w2 + d3 w3 = 0 with d0 = det[w1 w2 w3], d1 = -det[w0 w2 w3], d2 = det[w0 w1 w3], d3 =
/// -det[w0 w1 w2] (Cramer). Where all d have one sign or are zero, and some are not, the origin is a convex
/// combination of the w: with w = b - a, one point is a combination of vertices of A and of B.
class OriginInTetrahedron {
 public:
  OriginInTetrahedron(DifferenceDeterminant& determinant, const std::array<Difference, 3>& w)
      : w2_(w[2]),
        across12_(determinant, w[1], w[2]),
        across02_(determinant, w[0], w[2]),
        across01_(determinant, w[0], w[1]) {}

  /// @param w3 the fourth vertex.
  bool with(Difference w3) {
    const int d0 = across12_.sign(w3);
    const int d1 = -across02_.sign(w3);
    if (d0 * d1 < 0) return false;
    const int d2 = across01_.sign(w3);
    if (d0 * d2 < 0 || d1 * d2 < 0) return false;
    if (!d3_) d3_ = -across01_.sign(w2_);
    const int d3 = *d3_;
    if (d0 * d3 < 0 || d1 * d3 < 0 || d2 * d3 < 0) return false;
    return d0 != 0 || d1 != 0 || d2 != 0 || d3 != 0;
  }

  /// The origin is at an edge of the triangle: with some vertex of W across that edge, it is held.
  bool with_any() {
    for (int i = 0; i < kFirstOfB; ++i)
      for (int j = kFirstOfB; j < 16; ++j)
        if (with({i, j})) return true;
    return false;
  }

 private:
  Difference w2_;
  DirectionSigns across12_, across02_, across01_;
  std::optional<int> d3_;  // det[w0 w1 w2], negated, once asked for
};

/// u x v is perpendicular to a facet of one solid, whose plane passes through `on`, or to an edge of each, on
/// the plane through A's.
struct CandidatePlane {
  Difference u, v;
  int on;
};

/// The first three different of one solid's indices, if there are three.
std::optional<CandidatePlane> facet_plane(const std::array<std::uint8_t, 3>& of, int first) {
  if (of[0] == of[1] || of[1] == of[2] || of[0] == of[2]) return std::nullopt;
  const int i = first + of[0], j = first + of[1], k = first + of[2];
  return CandidatePlane{{i, j}, {i, k}, i};
}

/// Lines between different points of one solid's three, each once.
struct Lines {
  std::array<Difference, 3> of;
  int count = 0;
};

Lines lines_between(const std::array<std::uint8_t, 3>& of, int first) {
  Lines out;
  for (int k = 0; k < 3; ++k) {
    const int p = of[k], q = of[(k + 1) % 3];
    const bool known = out.count == 1 && (q == of[0] || q == of[1]) && (p == of[0] || p == of[1]);
    if (p != q && !known) out.of[out.count++] = {first + p, first + q};
  }
  return out;
}

/// Which of eight points are on the plane and beside it, as bits of all sixteen; not all where it has some on
/// both sides.
struct Sides {
  unsigned above = 0, below = 0, on = 0;

  bool is_cut() const { return above != 0 && below != 0; }
};

Sides sides_of(DirectionSigns& signs, const CandidatePlane& plane, int first) {
  const unsigned known = 1u << plane.on | 1u << plane.u.q | (plane.v.p == plane.on ? 1u << plane.v.q : 0u);
  Sides out;
  for (int i = first; i < first + 8 && !out.is_cut(); ++i) {
    const unsigned bit = 1u << i;
    const int side = (known & bit) != 0 ? 0 : signs.sign({plane.on, i});
    (side > 0 ? out.above : side < 0 ? out.below : out.on) |= bit;
  }
  return out;
}

/// A and B touch a common plane from its two sides: their faces there decide. u and v, not parallel, are
/// among their edges, so the polygon {b - a} has an inside, and polygons without a common point lie strictly
/// on two sides of a line along an edge of one of them; any two vertices' line will do.
bool polygons_separate(DifferenceDeterminant& determinant, unsigned a, unsigned b, int axis) {
  const auto separates = [&](Difference line) {
    int side = 0;
    for (unsigned rest_a = a; rest_a != 0; rest_a &= rest_a - 1) {
      for (unsigned rest_b = b; rest_b != 0; rest_b &= rest_b - 1) {
        const Difference w{std::countr_zero(rest_a), std::countr_zero(rest_b)};
        const int s = determinant.cross_sign(line, w, axis);
        if (s == 0 || s == -side) return false;
        side = s;
      }
    }
    return true;
  };
  for (const unsigned polygon : {a, b}) {
    for (unsigned p = polygon; p != 0; p &= p - 1)
      for (unsigned q = p & (p - 1); q != 0; q &= q - 1)
        if (separates({std::countr_zero(p), std::countr_zero(q)})) return true;
  }
  return false;
}

Vector3 rounded(const DifferenceDeterminant& determinant, Difference d) {
  return determinant.point(d.q) - determinant.point(d.p);
}

/// The square of the sine that rounding of vertices may leave between parallel edges, some u.
constexpr double kParallelSquare = 0x1p-96;

/// Lines that rounding alone has turned from each other: what is across both separates nothing, or next to. A
/// guess: what is left out here is asked of all directions later.
bool are_parallel(const DifferenceDeterminant& determinant, const CandidatePlane& plane) {
  const Vector3 u = rounded(determinant, plane.u), v = rounded(determinant, plane.v), n = cross(u, v);
  return !(dot(n, n) > kParallelSquare * (dot(u, u) * dot(v, v)));
}

/// A component of u x v that is not zero, so that dropping it maps the plane one to one; the largest first.
std::optional<int> injective_axis(DifferenceDeterminant& determinant, const CandidatePlane& plane) {
  const Vector3 n = cross(rounded(determinant, plane.u), rounded(determinant, plane.v));
  int largest = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n(k)) > std::abs(n(largest))) largest = k;
  for (const int axis : {largest, (largest + 1) % 3, (largest + 2) % 3})
    if (determinant.cross_sign(plane.u, plane.v, axis) != 0) return axis;
  return std::nullopt;
}

Certified certify_on(DifferenceDeterminant& determinant, const CandidatePlane& plane) {
  DirectionSigns signs(determinant, plane.u, plane.v);
  const Sides a = sides_of(signs, plane, 0);
  if (a.is_cut()) return Certified::unknown;
  const Sides b = sides_of(signs, plane, kFirstOfB);
  if (b.is_cut()) return Certified::unknown;
  if (b.on == 0 || a.on == 0) {
    // All of one side: apart when the other solid is on the other, or in the plane.
    const bool same_side = (a.above != 0 && b.above != 0) || (a.below != 0 && b.below != 0);
    return same_side ? Certified::unknown : Certified::separated;
  }
  if ((a.above != 0 && b.above != 0) || (a.below != 0 && b.below != 0)) return Certified::unknown;
  const unsigned edges = 1u << plane.u.q | 1u << plane.v.p | 1u << plane.v.q;
  if ((edges & ~(a.on | b.on)) != 0) return Certified::unknown;
  const std::optional<int> axis = injective_axis(determinant, plane);
  if (!axis) return Certified::unknown;
  return polygons_separate(determinant, a.on, b.on, *axis) ? Certified::separated : Certified::overlapping;
}

/// The vertex of W furthest inwards from the triangle, to rounding.
Difference furthest_inwards(const DifferenceDeterminant& determinant, const std::array<Difference, 3>& w) {
  const auto d = [&](Difference x) { return rounded(determinant, x); };
  const Vector3 w0 = d(w[0]);
  const Vector3 n = cross(d(w[1]) - w0, d(w[2]) - w0);
  std::array<double, 16> along;
  for (int i = 0; i < 16; ++i) along[i] = dot(n, determinant.point(i));
  Difference high{0, kFirstOfB}, low{0, kFirstOfB};
  for (int i = 1; i < kFirstOfB; ++i) {
    const int j = kFirstOfB + i;
    if (along[i] < along[high.p]) high.p = i;
    if (along[i] > along[low.p]) low.p = i;
    if (along[j] > along[high.q]) high.q = j;
    if (along[j] < along[low.q]) low.q = j;
  }
  return std::abs(dot(n, d(high) - w0)) > std::abs(dot(n, d(low) - w0)) ? high : low;
}

}  // namespace

Certified certify_near(ExactPair& pair, const MinkowskiTriangle& guess) noexcept {
  DifferenceDeterminant& determinant = pair.determinant;
  std::array<Difference, 3> w;
  for (int k = 0; k < 3; ++k) {
    w[k] = {guess.a[k], kFirstOfB + guess.b[k]};
    if (determinant.is_zero(w[k])) return Certified::overlapping;
  }
  // Of pairs that meet nearly all are held by W; planes tell of those that are apart, and touch along edges.
  OriginInTetrahedron origin(determinant, w);
  if (origin.with(furthest_inwards(determinant, w)) || origin.with_any()) return Certified::overlapping;
  for (const auto& plane : {facet_plane(guess.a, 0), facet_plane(guess.b, kFirstOfB)}) {
    const Certified certified = plane ? certify_on(determinant, *plane) : Certified::unknown;
    if (certified != Certified::unknown) return certified;
  }
  const Lines of_a = lines_between(guess.a, 0), of_b = lines_between(guess.b, kFirstOfB);
  for (int i = 0; i < of_a.count; ++i) {
    for (int j = 0; j < of_b.count; ++j) {
      const CandidatePlane plane{of_a.of[i], of_b.of[j], of_a.of[i].p};
      if (are_parallel(determinant, plane)) continue;
      const Certified certified = certify_on(determinant, plane);
      if (certified != Certified::unknown) return certified;
    }
  }
  return Certified::unknown;
}

}  // namespace touchstone::numerics
