#include "contact_core/native/distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_core/native/double_double.hpp"
#include "contact_core/native/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// Witness points off by more than this many u * extent make penetration() look at near ties.
constexpr double kWitness = 32;
/// On the supporting plane to rounding: so many u * extent (of the moved pair).
constexpr double kSupport = 8;
/// Below this share of the extent, u * extent / |v| costs the normal more than 2^6 u, and v is computed anew.
constexpr double kShort = 0x1p-6;
/// Upper and lower bound must agree to this many u * extent.
constexpr double kGap = 16;

/// A triangle whose barycentric coordinates miss the sum 1 by more is too thin even for double-double.
constexpr double kSliver = 0x1p-40;

DoubleDouble3 minkowski_vertex(const HullPair& hulls, const Simplex& s, int i) {
  return difference(hulls.b.vertex(s.b[i]), hulls.a.vertex(s.a[i]));
}

/// Sets n and separation from the flat through the simplex's vertices, and the weights of the foot point.
/// False where the simplex has no flat of its dimension or the foot lies outside it.
bool foot_on_edge(const DoubleDouble3& w0, const DoubleDouble3& w1, Simplex& s, DoubleDouble3& v) {
  const DoubleDouble3 e = w1 - w0;
  const DoubleDouble length2 = dot(e, e);
  if (!(length2.high > 0.0)) return false;
  const DoubleDouble t = -(dot(w0, e) / length2);
  if (t.high < 0.0 || t.high > 1.0) return false;
  s.weight = {1.0 - t.high, t.high, 0.0, 0.0};
  v = w0 + t * e;
  return true;
}

bool foot_on_triangle(const DoubleDouble3& w0, const DoubleDouble3& w1, const DoubleDouble3& w2, Simplex& s,
                      SignedDistance& out) {
  const DoubleDouble3 e1 = w1 - w0, e2 = w2 - w0;
  const DoubleDouble3 normal = cross(e1, e2);
  const DoubleDouble square = dot(normal, normal);
  if (!(square.high > 0.0)) return false;
  const double second = (dot(cross(w2, w0), normal) / square).high;
  const double third = (dot(cross(w0, w1), normal) / square).high;
  const double first = (dot(cross(w1, w2), normal) / square).high;
  if (first < 0.0 || second < 0.0 || third < 0.0) return false;
  const double sum = (first + second) + third;
  if (!(std::abs(sum - 1.0) <= kSliver)) return false;
  s.weight = {first / sum, second / sum, third / sum, 0.0};
  const DoubleDouble height = dot(normal, w0);
  const Vector3 direction = normal.rounded();
  const double length = norm(direction);
  out.separation = std::abs(height.high) / length;
  out.n = direction / (height.high < 0.0 ? -length : length);
  return true;
}

bool recompute(const HullPair& hulls, Simplex& s, SignedDistance& out) {
  const DoubleDouble3 w0 = minkowski_vertex(hulls, s, 0);
  if (s.count == 3)
    return foot_on_triangle(w0, minkowski_vertex(hulls, s, 1), minkowski_vertex(hulls, s, 2), s, out);
  DoubleDouble3 v = w0;
  if (s.count == 2 && !foot_on_edge(w0, minkowski_vertex(hulls, s, 1), s, v)) return false;
  const Vector3 direction = v.rounded();
  const double length = norm(direction);
  if (!(length > 0.0)) return false;
  out.separation = length;
  out.n = direction / length;
  return true;
}

bool agrees(const HullPair& hulls, const SignedDistance& d) {
  return d.separation - separation_along(hulls, d.n) <= kGap * kRoundoff * hulls.extent;
}

struct Point2 {
  double x, y;
};

double determinant(const Point2& p, const Point2& q) { return difference_of_products(p.x, q.y, p.y, q.x); }

/// Weights of the point of the segment nearest the origin; returns its square distance.
double weigh_segment(const std::array<Point2, 3>& t, int i, int j, std::array<double, 4>& weight) {
  const Point2 e{t[j].x - t[i].x, t[j].y - t[i].y};
  const double square = e.x * e.x + e.y * e.y;
  double part = square > 0.0 ? -(t[i].x * e.x + t[i].y * e.y) / square : 0.0;
  part = std::clamp(part, 0.0, 1.0);
  weight = {};
  weight[i] = 1.0 - part, weight[j] = part;
  const Point2 foot{t[i].x + part * e.x, t[i].y + part * e.y};
  return foot.x * foot.x + foot.y * foot.y;
}

/// The search fixes the direction of v only to the square root of what it fixes |v| to. Seen along the known
/// n the problem is plane: the weights whose combination of the vertices lies over the origin, by Cramer's
/// rule with exact products, so that slivers too leave no more than the rounding of the projected vertices.
void weigh_along(const Vector3& n, Simplex& s) {
  if (s.count < 2) return;
  const TangentFrame frame = tangent_frame(n);
  std::array<Point2, 3> t{};
  for (int i = 0; i < s.count; ++i) t[i] = {dot(s.w[i], frame.x), dot(s.w[i], frame.y)};
  if (s.count == 2) {
    weigh_segment(t, 0, 1, s.weight);
    return;
  }
  const double first = determinant(t[1], t[2]), second = determinant(t[2], t[0]),
               third = determinant(t[0], t[1]);
  const double sum = (first + second) + third;
  const bool inside = sum > 0.0 ? first >= 0.0 && second >= 0.0 && third >= 0.0
                                : sum < 0.0 && first <= 0.0 && second <= 0.0 && third <= 0.0;
  if (inside) {
    s.weight = {first / sum, second / sum, third / sum, 0.0};
    return;
  }
  double least = weigh_segment(t, 0, 1, s.weight);
  for (int i = 0; i < 2; ++i) {
    std::array<double, 4> weight{};
    const double square = weigh_segment(t, i, 2, weight);
    if (square < least) least = square, s.weight = weight;
  }
}

/// The vertices of W that are least along n to rounding, over which the origin lies: of thin solids, whose
/// faces the rounding of world vertices tilts, the search may end on a neighbouring facet. Tries every
/// triangle; keeps the best edge otherwise. Returns false when there is nothing to weigh.
bool weigh_support_facet(const HullPair& hulls, const Vector3& n, Simplex& s) {
  const double high = support_high(hulls.a, n).value, low = support_low(hulls.b, n).value;
  const double tolerance = kSupport * kRoundoff * hulls.extent;
  const TangentFrame frame = tangent_frame(n);
  std::array<std::uint8_t, 64> on_a{}, on_b{};
  std::array<Point2, 64> points{};
  int count = 0;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = hulls.a.vertex(i);
    if (dot(p, n) < high - tolerance) continue;
    for (int j = 0; j < 8; ++j) {
      const Vector3 q = hulls.b.vertex(j);
      if (dot(q, n) > low + tolerance) continue;
      on_a[count] = static_cast<std::uint8_t>(i), on_b[count] = static_cast<std::uint8_t>(j);
      points[count++] = {dot(q - p, frame.x), dot(q - p, frame.y)};
    }
  }
  const auto keep = [&](int i, int j, int k, const std::array<double, 4>& weight) {
    s.count = 3;
    s.a = {on_a[i], on_a[j], on_a[k], 0}, s.b = {on_b[i], on_b[j], on_b[k], 0};
    for (int m = 0; m < 3; ++m) s.w[m] = hulls.b.vertex(s.b[m]) - hulls.a.vertex(s.a[m]);
    s.weight = weight;
  };
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    for (int j = i; j < count; ++j) {
      std::array<double, 4> weight{};
      const double square = weigh_segment({points[i], points[j], points[j]}, 0, 1, weight);
      if (square < least) least = square, keep(i, j, j, weight);
      for (int k = j + 1; k < count; ++k) {
        const double first = determinant(points[j], points[k]), second = determinant(points[k], points[i]);
        const double third = determinant(points[i], points[j]), sum = (first + second) + third;
        const bool inside = sum > 0.0 ? first >= 0.0 && second >= 0.0 && third >= 0.0
                                      : sum < 0.0 && first <= 0.0 && second <= 0.0 && third <= 0.0;
        if (!inside) continue;
        keep(i, j, k, {first / sum, second / sum, third / sum, 0.0});
        return true;
      }
    }
  }
  return count > 0;
}

Vector3 combination(const Simplex& s) {
  Vector3 v = s.weight[0] * s.w[0];
  for (int i = 1; i < s.count; ++i) v += s.weight[i] * s.w[i];
  return v;
}

struct Witness {
  Vector3 p_A;
  double error;  ///< how far the two points' difference is from lying straight along n
};

/// One point of A whose partner lies straight across along n: B is moved to a comfortable gap along n, where
/// the closest points are well defined, also for pairs that touch or overlap.
Witness witness_along(const PosedPair& pair, double separation, const Vector3& n) {
  HullPair moved = pair.hulls;
  const double gap = 0.5 * pair.hulls.extent;
  const Vector3 shift = (gap - separation) * n;
  for (int i = 0; i < 8; ++i) {
    moved.b.x[i] += shift.x(), moved.b.y[i] += shift.y(), moved.b.z[i] += shift.z();
  }
  moved.extent = 4 * pair.hulls.extent;
  Simplex s;
  double error = std::numeric_limits<double>::infinity();
  if (closest_point(moved, n, error, s) == Search::found) {
    weigh_along(n, s);
    error = norm(combination(s) - gap * n);
    if (error <= kWitness * kRoundoff * pair.hulls.extent) return {point_on_a(moved, s), error};
  }
  Simplex facet;
  if (!weigh_support_facet(moved, n, facet))
    return {pair.hulls.a.vertex(support_high(pair.hulls.a, n).index), error};
  const double facet_error = norm(combination(facet) - gap * n);
  if (facet_error < error) return {point_on_a(moved, facet), facet_error};
  return {point_on_a(moved, s), error};
}

/// A candidate axis that is no facet normal can come within rounding of the best (two facets at a small
/// angle, or a small depth under a corner); its witness points are then off by up to sqrt(2 u * depth *
/// extent). The facet's own are not.
void settle_near_ties(const PosedPair& pair, SignedDistance& result) {
  Witness best = witness_along(pair, result.separation, result.n);
  if (best.error > kWitness * kRoundoff * pair.hulls.extent) {
    NearTies ties;
    find_near_ties(pair.hulls, *pair.a, pair.R_WA, *pair.b, pair.R_WB, result.separation, ties);
    for (int i = 0; i < ties.count; ++i) {
      const double separation = std::min(ties.axes[i].separation, 0.0);
      const Witness other = witness_along(pair, separation, ties.axes[i].n);
      if (!(other.error < best.error)) continue;
      best = other;
      result.separation = separation, result.n = ties.axes[i].n;
    }
  }
  result.p_A = best.p_A;
}

struct BestDirection {
  const HullPair& hulls;
  SeparationAxis best;

  void consider(const Vector3& v) {
    const double length = norm(v);
    if (!(length > 0.0)) return;
    const Vector3 n = v / length;
    const double separation = separation_along(hulls, n);
    if (separation > best.separation) best = {separation, n};
  }
};

void consider_vertex_and_edge(const Vector3& p, const Vector3& from, const Vector3& to, double sign,
                              BestDirection& directions) {
  const DoubleDouble3 w0 = difference(from, p), w1 = difference(to, p);
  Simplex unused;
  DoubleDouble3 v;
  if (foot_on_edge(w0, w1, unused, v)) directions.consider(sign * v.rounded());
}

/// The distance is the greatest separation over all directions, reached at a facet normal or across two
/// vertices or a vertex and an edge: all are tried.
SeparationAxis search_all_features(const PosedPair& pair) {
  BestDirection directions{pair.hulls, best_facet_axis(pair.hulls, *pair.a, pair.R_WA, *pair.b, pair.R_WB)};
  const WorldVertices& a = pair.hulls.a;
  const WorldVertices& b = pair.hulls.b;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = a.vertex(i), q = b.vertex(i);
    for (int j = 0; j < 8; ++j) directions.consider(b.vertex(j) - p);
    for (int j = 0; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        consider_vertex_and_edge(p, b.vertex(j), b.vertex(k), 1.0, directions);
        consider_vertex_and_edge(q, a.vertex(j), a.vertex(k), -1.0, directions);
      }
    }
  }
  return directions.best;
}

}  // namespace

bool distance_apart(const PosedPair& pair, double limit, SignedDistance& result) {
  Simplex s;
  const Search search = closest_point(pair.hulls, pair.start, limit, s);
  if (search == Search::beyond) return false;
  if (search == Search::found) {
    const double length = norm(s.v);
    bool known = true;
    if (length > kShort * pair.hulls.extent) {
      result.separation = length;
      result.n = s.v / length;
    } else {
      known = recompute(pair.hulls, s, result);
    }
    // v itself may lie off W where the simplex is a sliver; the weighted point never does.
    if (known && length > kShort * pair.hulls.extent &&
        !agrees(pair.hulls, {norm(combination(s)), result.n, {}}))
      known = recompute(pair.hulls, s, result);
    if (known && agrees(pair.hulls, result)) {
      result.p_A = point_on_a(pair.hulls, s);
      return true;
    }
  }
  const SeparationAxis axis = search_all_features(pair);
  result = {axis.separation, axis.n, witness_along(pair, axis.separation, axis.n).p_A};
  return true;
}

void penetration(const PosedPair& pair, SignedDistance& result) {
  const SeparationAxis axis = best_facet_axis(pair.hulls, *pair.a, pair.R_WA, *pair.b, pair.R_WB);
  result = {std::min(axis.separation, 0.0), axis.n, Vector3::Zero()};
  settle_near_ties(pair, result);
}

}  // namespace touchstone::native
