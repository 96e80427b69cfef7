#include "touchstone/contact_core/native/overlap/gjk.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::native {
namespace {

/// Random pairs take 4 to 8 iterations; W's 64 vertices have never needed this many.
constexpr int kMaxIterations = 64;

void keep_one(Simplex& s, int i) {
  s.a[0] = s.a[i], s.b[0] = s.b[i];
  s.v = s.w[0] = Vector3(s.w[i]);
  s.weight[0] = 1.0;
  s.count = 1;
}

void keep_two(Simplex& s, int i, int j, double weight_j) {
  const Vector3 wi = s.w[i], wj = s.w[j];
  const std::array<std::uint8_t, 4> a{s.a[i], s.a[j]}, b{s.b[i], s.b[j]};
  s.a = a, s.b = b;
  s.w[0] = wi, s.w[1] = wj;
  s.weight = {1.0 - weight_j, weight_j};
  s.v = wi + weight_j * (wj - wi);
  s.count = 2;
}

void nearest_on_segment(Simplex& s, int i, int j) {
  const Vector3 e = s.w[j] - s.w[i];
  const double along = -dot(s.w[i], e);
  const double length2 = dot(e, e);
  if (!(along > 0.0)) return keep_one(s, i);
  if (along >= length2) return keep_one(s, j);
  keep_two(s, i, j, along / length2);
}

void nearest_on_triangle(Simplex& s, int i, int j, int k) {
  const Vector3 p = s.w[i], q = s.w[j], r = s.w[k];
  const Vector3 pq = q - p, pr = r - p;
  const double d1 = -dot(pq, p), d2 = -dot(pr, p);
  if (d1 <= 0.0 && d2 <= 0.0) return keep_one(s, i);
  const double d3 = -dot(pq, q), d4 = -dot(pr, q);
  if (d3 >= 0.0 && d4 <= d3) return keep_one(s, j);
  const double d5 = -dot(pq, r), d6 = -dot(pr, r);
  if (d6 >= 0.0 && d5 <= d6) return keep_one(s, k);
  // Areas of the sub-triangles from the normal: the differences d1 d4 - d3 d2 cancel where the triangle is
  // thin.
  const Vector3 n = cross(pq, pr);
  const double area_r = dot(n, cross(p, q));
  if (area_r <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return nearest_on_segment(s, i, j);
  const double area_q = dot(n, cross(r, p));
  if (area_q <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return nearest_on_segment(s, i, k);
  const double area_p = dot(n, cross(q, r));
  if (area_p <= 0.0 && d4 >= d3 && d5 >= d6) return nearest_on_segment(s, j, k);
  const double total = (area_p + area_q) + area_r;
  if (!(total > 0.0) || area_p < 0.0 || area_q < 0.0 || area_r < 0.0) {
    // A sliver: no region claims the origin to rounding. The best edge does.
    Simplex best = s;
    nearest_on_segment(best, i, j);
    for (const auto& [from, to] : {std::array{i, k}, std::array{j, k}}) {
      Simplex other = s;
      nearest_on_segment(other, from, to);
      if (dot(other.v, other.v) < dot(best.v, best.v)) best = other;
    }
    s = best;
    return;
  }
  const std::array<std::uint8_t, 4> a{s.a[i], s.a[j], s.a[k]}, b{s.b[i], s.b[j], s.b[k]};
  s.a = a, s.b = b;
  s.w[0] = p, s.w[1] = q, s.w[2] = r;
  s.weight = {area_p / total, area_q / total, area_r / total};
  s.v = n * (dot(n, p) / dot(n, n));
  s.count = 3;
}

/// False: the origin lies inside, to rounding.
bool nearest_on_tetrahedron(Simplex& s) {
  constexpr int kFaces[4][4] = {
      {3, 0, 1, 2}, {3, 1, 2, 0}, {3, 2, 0, 1}, {0, 1, 2, 3}};  // face, opposite vertex
  Simplex best;
  double best_square = 0.0;
  for (const auto& f : kFaces) {
    const Vector3& p = s.w[f[0]];
    const Vector3 n = cross(s.w[f[1]] - p, s.w[f[2]] - p);
    const double origin_side = -dot(n, p);
    const double inner_side = dot(n, s.w[f[3]] - p);
    if ((origin_side > 0.0 && inner_side > 0.0) || (origin_side < 0.0 && inner_side < 0.0)) continue;
    Simplex face = s;
    nearest_on_triangle(face, f[0], f[1], f[2]);
    const double square = dot(face.v, face.v);
    if (best.count == 0 || square < best_square) best = face, best_square = square;
  }
  if (best.count == 0) return false;
  s = best;
  return true;
}

bool nearest_on_simplex(Simplex& s) {
  if (s.count == 2) {
    nearest_on_segment(s, 0, 1);
  } else if (s.count == 3) {
    nearest_on_triangle(s, 0, 1, 2);
  } else if (s.count == 4) {
    return nearest_on_tetrahedron(s);
  }
  return true;
}

struct MinkowskiSupport {
  int a, b;
  double value;  // least axis . w
};

MinkowskiSupport least_along(const HullPair& pair, const Vector3& axis) {
  const Support high = support_high(pair.a, axis);
  const Support low = support_low(pair.b, axis);
  return {high.index, low.index, low.value - high.value};
}

bool holds(const Simplex& s, const MinkowskiSupport& support) {
  for (int i = 0; i < s.count; ++i)
    if (s.a[i] == support.a && s.b[i] == support.b) return true;
  return false;
}

void append(const HullPair& pair, const MinkowskiSupport& support, Simplex& s) {
  s.a[s.count] = static_cast<std::uint8_t>(support.a);
  s.b[s.count] = static_cast<std::uint8_t>(support.b);
  s.w[s.count] = pair.b.vertex(support.b) - pair.a.vertex(support.a);
  ++s.count;
}

/// Bounds the error of a product that underflows.
constexpr double kLeast = 0x1p-1074;

/// Of certify_hulls: three products a projection may underflow besides.
double certain_gap(const Vector3& axis, double extent) { return projection_error(axis, extent) + 8 * kLeast; }

/// The origin is strictly inside the tetrahedron of the exact w. Each coordinate of a computed w is off by at
/// most 4 u M (the two shifts and the difference; M the extent), so each of a determinant's 6 products, each
/// at most W^3 (W the largest coordinate), is off by 12 u M W^2, and its evaluation (three roundings a
/// product, three sums of at most 6 W^3) adds 8 u W^3 a product. Underflow takes
/// at most the least double from each product: from a determinant 6 W + 3 of them, from this bound as
/// computed 1 + (9 W + 13 M).
bool certainly_holds_origin(const Simplex& s, double extent) {
  const double d0 = dot(s.w[1], cross(s.w[2], s.w[3]));
  const double d1 = -dot(s.w[0], cross(s.w[2], s.w[3]));
  const double d2 = dot(s.w[0], cross(s.w[1], s.w[3]));
  const double d3 = -dot(s.w[0], cross(s.w[1], s.w[2]));
  double reach = 0.0;
  for (int i = 0; i < 4; ++i) reach = std::max(reach, norm_inf(s.w[i]));
  const double bound = 9 * reach + 13 * extent;
  const double error = 6 * kRoundoff * reach * reach * bound + 16 * kLeast * (1.0 + reach + bound);
  return (d0 > error && d1 > error && d2 > error && d3 > error) ||
         (d0 < -error && d1 < -error && d2 < -error && d3 < -error);
}

Vector3 usable(const Vector3& start) { return dot(start, start) > 0.0 ? start : Vector3(Vector3::UnitX()); }

}  // namespace

Certified certify_hulls(const HullPair& pair, const Vector3& start) {
  Vector3 axis;
  return certify_hulls(pair, start, axis);
}

Certified certify_hulls(const HullPair& pair, const Vector3& start, Vector3& axis) {
  // The axis given separates most pairs that it separated before.
  const Vector3 first = usable(start);
  MinkowskiSupport support = least_along(pair, first);
  if (support.value > certain_gap(first, pair.extent)) {
    axis = first;
    return Certified::separated;
  }
  // GJK: the simplex comes nearer to the origin until it holds it, or an axis separates, or it gains nothing.
  Simplex s;
  append(pair, support, s);
  s.weight[0] = 1.0;
  s.v = s.w[0];
  double square = dot(s.v, s.v);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    support = least_along(pair, s.v);
    if (support.value > certain_gap(s.v, pair.extent)) {
      axis = s.v;
      return Certified::separated;
    }
    if (holds(s, support)) return Certified::unknown;
    append(pair, support, s);
    if (s.count == 4 && certainly_holds_origin(s, pair.extent)) return Certified::overlapping;
    if (!nearest_on_simplex(s)) return Certified::unknown;
    const double next = dot(s.v, s.v);
    if (!(next < square)) return Certified::unknown;
    square = next;
  }
  return Certified::unknown;
}

Search closest_point(const HullPair& pair, const Vector3& start, double limit, Simplex& s) {
  s.count = 0;
  append(pair, least_along(pair, usable(start)), s);
  s.weight[0] = 1.0;
  s.v = s.w[0];
  double square = dot(s.v, s.v);
  const double tolerance = 2 * kRoundoff * pair.extent;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (square == 0.0) return Search::lost;
    const MinkowskiSupport support = least_along(pair, s.v);
    const double certain = support.value - 2 * projection_error(s.v, pair.extent);
    if (certain > 0.0 && certain > limit * std::sqrt(square)) return Search::beyond;
    // |v| - support / |v| bounds how much nearer W can come.
    const double gap = square - support.value;
    if (gap <= 0.0 || gap * gap <= tolerance * tolerance * square) return Search::found;
    if (holds(s, support)) return Search::found;
    const Simplex before = s;
    append(pair, support, s);
    if (!nearest_on_simplex(s)) return Search::lost;
    const double next = dot(s.v, s.v);
    if (!(next < square)) {
      s = before;
      return Search::found;
    }
    square = next;
  }
  return Search::lost;
}

Vector3 point_on_a(const HullPair& pair, const Simplex& s) {
  Vector3 p = s.weight[0] * pair.a.vertex(s.a[0]);
  for (int i = 1; i < s.count; ++i) p += s.weight[i] * pair.a.vertex(s.a[i]);
  return p;
}

}  // namespace touchstone::native
