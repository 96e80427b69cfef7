#include "touchstone/contact_core/native/distance/witness.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/common/double_double.hpp"
#include "touchstone/contact_core/native/common/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// Distance within which a vertex is on the supporting plane: in u * extent (of the moved pair).
constexpr double kSupport = 8;
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
/// triangle; keeps the best edge otherwise. Returns false when there is no such vertex.
bool weigh_support_facet(const HullPair& hulls, const Vector3& n, Simplex& s) {
  const double high = support_high(hulls.a, n).value, low = support_low(hulls.b, n).value;
  const double tolerance = kSupport * kRoundoff * hulls.extent;
  // The candidates, in the plane across n.
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
  // A triangle over the origin ends the search; the nearest edge is kept meanwhile.
  double least = kInfinity;
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

}  // namespace

Vector3 combination(const Simplex& s) {
  Vector3 v = s.weight[0] * s.w[0];
  for (int i = 1; i < s.count; ++i) v += s.weight[i] * s.w[i];
  return v;
}

Witness witness_along(const PosedPair& pair, double separation, const Vector3& n) {
  HullPair moved = pair.hulls;
  const double gap = 0.5 * pair.hulls.extent;
  const Vector3 shift = (gap - separation) * n;
  for (int i = 0; i < 8; ++i) {
    moved.b.x[i] += shift.x(), moved.b.y[i] += shift.y(), moved.b.z[i] += shift.z();
  }
  moved.extent = 4 * pair.hulls.extent;
  Simplex s;
  double error = kInfinity;
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

}  // namespace touchstone::native
