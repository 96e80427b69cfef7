#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

// A slow signed distance in long double, from the definition: apart, the least distance between features;
// else the least depth over face normals and edge cross products. Shares no code with what it checks.

namespace touchstone::test {

using Real = long double;
using Point = std::array<Real, 3>;

inline Point operator-(const Point& u, const Point& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
inline Point operator+(const Point& u, const Point& v) { return {u[0] + v[0], u[1] + v[1], u[2] + v[2]}; }
inline Point operator*(Real s, const Point& u) { return {s * u[0], s * u[1], s * u[2]}; }
inline Real inner(const Point& u, const Point& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
inline Point outer(const Point& u, const Point& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
inline Real length(const Point& u) { return std::sqrt(inner(u, u)); }

using Corners = std::array<Point, 8>;

inline Corners corners(const Hexahedron& solid, const Pose& X_WS) {
  WorldVertices v;
  world_vertices(solid, X_WS, v);
  Corners out;
  for (int i = 0; i < 8; ++i) out[i] = {v.x[i], v.y[i], v.z[i]};
  return out;
}

inline Real gap_along(const Corners& a, const Corners& b, Point axis) {
  const Real scale = length(axis);
  Real a_low = std::numeric_limits<Real>::infinity(), b_low = a_low, a_high = -a_low, b_high = -a_low;
  for (int i = 0; i < 8; ++i) {
    const Real s = inner(axis, a[i] - a[0]) / scale, t = inner(axis, b[i] - a[0]) / scale;
    a_low = std::min(a_low, s), a_high = std::max(a_high, s);
    b_low = std::min(b_low, t), b_high = std::max(b_high, t);
  }
  return std::max(b_low - a_high, a_low - b_high);
}

inline Real segment_distance(const Point& p, const Point& u, const Point& q, const Point& v) {
  const Point w = p - q;
  const Real a = inner(u, u), b = inner(u, v), c = inner(v, v), d = inner(u, w), e = inner(v, w);
  const auto at = [&](Real s, Real t) { return length(w + s * u - t * v); };
  const auto unit = [](Real x) { return std::clamp<Real>(x, 0, 1); };
  Real best =
      std::min({at(0, unit(e / c)), at(1, unit((e + b) / c)), at(unit(-d / a), 0), at(unit((b - d) / a), 1)});
  const Real determinant = a * c - b * b;
  if (determinant > 1e-18L * a * c) {
    const Real s = (b * e - c * d) / determinant, t = (a * e - b * d) / determinant;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = std::min(best, at(s, t));
  }
  return best;
}

inline Point face_normal(const Corners& v, int face) {
  const auto& quad = Hexahedron::kFaceVertices[face];
  return outer(v[quad[2]] - v[quad[0]], v[quad[3]] - v[quad[1]]);
}

/// From p to the face of v when p lies above it, else infinite.
inline Real face_distance(const Corners& v, int face, const Point& p) {
  const auto& quad = Hexahedron::kFaceVertices[face];
  const Point normal = face_normal(v, face);
  for (int i = 0; i < 4; ++i) {
    const Point side = v[quad[(i + 1) % 4]] - v[quad[i]];
    if (inner(outer(normal, side), p - v[quad[i]]) < 0) return std::numeric_limits<Real>::infinity();
  }
  return std::abs(inner(normal, p - v[quad[0]])) / length(normal);
}

inline Real signed_distance(const Corners& a, const Corners& b) {
  Real widest = -std::numeric_limits<Real>::infinity();
  for (int f = 0; f < 6; ++f)
    widest = std::max({widest, gap_along(a, b, face_normal(a, f)), gap_along(a, b, face_normal(b, f))});
  Real nearest = std::numeric_limits<Real>::infinity();
  for (const auto& m : Hexahedron::kEdgeVertices) {
    for (const auto& n : Hexahedron::kEdgeVertices) {
      const Point u = a[m[1]] - a[m[0]], v = b[n[1]] - b[n[0]], axis = outer(u, v);
      // Parallel edges add no axis that the faces do not have.
      if (length(axis) > 1e-12L * length(u) * length(v)) widest = std::max(widest, gap_along(a, b, axis));
      nearest = std::min(nearest, segment_distance(a[m[0]], u, b[n[0]], v));
    }
  }
  if (widest <= 0) return widest;
  for (int f = 0; f < 6; ++f)
    for (int i = 0; i < 8; ++i)
      nearest = std::min({nearest, face_distance(a, f, b[i]), face_distance(b, f, a[i])});
  return nearest;
}

inline double signed_distance(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b, const Pose& X_WB) {
  return static_cast<double>(signed_distance(corners(a, X_WA), corners(b, X_WB)));
}

}  // namespace touchstone::test
