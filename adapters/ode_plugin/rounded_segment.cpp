#include "touchstone/adapters/ode_plugin/rounded_segment.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::ode_plugin {
namespace {

/// The edges that have not collapsed.
template <class Visit>
void visit_edges(std::span<const Vector3, Hexahedron::kVertices> vertices, Visit visit) {
  for (const auto& [from, to] : Hexahedron::kEdgeVertices)
    if (vertices[from] != vertices[to]) visit(vertices[from], vertices[to]);
}

/// The nearest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
struct Between {
  Vector3 on_first, on_second;
};
Between between(const Vector3& p1, const Vector3& q1, const Vector3& p2, const Vector3& q2) {
  const Vector3 d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = dot(d1, d1), e = dot(d2, d2), f = dot(d2, r), c = dot(d1, r), b = dot(d1, d2);
  double s = 0.0, t = 0.0;
  if (a == 0.0) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else {
    const double denominator = a * e - b * b;
    if (denominator > 0.0) s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
    t = (b * s + f) / e;
    if (t < 0.0 || t > 1.0) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  }
  return {p1 + s * d1, p2 + t * d2};
}

/// The axis along which the two overlap least, or are furthest apart.
Nearest best_axis(const Vector3& a, const Vector3& b,
                  std::span<const Vector3, Hexahedron::kVertices> vertices, std::span<const double> planes) {
  Nearest best{-kInfinity, Vector3::Zero(), a};
  for (std::size_t i = 0; i < planes.size(); i += 4) {
    const Vector3 n(planes[i], planes[i + 1], planes[i + 2]);
    const double above_a = dot(n, a) - planes[i + 3], above_b = dot(n, b) - planes[i + 3];
    const double least = std::min(above_a, above_b);
    const Vector3 at = above_a == above_b ? Vector3(0.5 * (a + b)) : above_a < above_b ? a : b;
    if (least > best.distance) best = {least, n, at};
  }
  visit_edges(vertices, [&](const Vector3& from, const Vector3& to) {
    Vector3 n = cross(to - from, b - a);
    const double length = norm(n);
    if (!(length > 1e-12 * norm(to - from) * norm(b - a))) return;  // parallel: a face's normal serves
    n = n / length;
    for (const double sign : {1.0, -1.0}) {
      double most = -kInfinity;
      for (const Vector3& vertex : vertices) most = std::max(most, sign * dot(n, vertex));
      const double least = sign * dot(n, a) - most;
      if (least > best.distance) best = {least, Vector3(sign * n), between(a, b, from, to).on_first};
    }
  });
  return best;
}

}  // namespace

Nearest nearest(const Vector3& a, const Vector3& b, std::span<const Vector3, Hexahedron::kVertices> vertices,
                std::span<const double> planes) {
  Nearest best = best_axis(a, b, vertices, planes);
  if (!(best.distance > 0.0)) return best;
  // Apart: over a face the axis is right already; else the way is from an edge of the solid's.
  const auto is_over_its_face = [&](const Vector3& p) {
    for (std::size_t i = 0; i < planes.size(); i += 4) {
      const Vector3 n(planes[i], planes[i + 1], planes[i + 2]);
      const double slack = 1e-12 * (std::abs(planes[i + 3]) + norm(p));
      if (dot(n, p - best.distance * best.n) - planes[i + 3] > slack) return false;
    }
    return true;
  };
  if (is_over_its_face(best.on_segment)) return best;
  // Over a face: one of the segment's ends.
  Nearest least{kInfinity, best.n, best.on_segment};
  for (const Vector3& end : {a, b})
    for (std::size_t i = 0; i < planes.size(); i += 4) {
      const Vector3 n(planes[i], planes[i + 1], planes[i + 2]);
      const double above = dot(n, end) - planes[i + 3];
      if (above <= 0.0 || above >= least.distance) continue;
      best = {above, n, end};
      if (is_over_its_face(end)) least = best;
    }
  // Over an edge: two points of two segments.
  visit_edges(vertices, [&](const Vector3& from, const Vector3& to) {
    const Between points = between(a, b, from, to);
    const Vector3 offset = points.on_first - points.on_second;
    const double distance = norm(offset);
    if (distance < least.distance && distance > 0.0)
      least = {distance, Vector3(offset / distance), points.on_first};
  });
  return least;
}

}  // namespace touchstone::ode_plugin
