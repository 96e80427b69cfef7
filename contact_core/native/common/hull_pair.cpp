#include "touchstone/contact_core/native/common/hull_pair.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/native/common/lanes.hpp"

namespace touchstone::native {
namespace {

/// Subtracts the origin's coordinate; returns the lanes' largest magnitudes.
Double2 shift(const std::array<double, 8>& from, double origin, std::array<double, 8>& to) {
  const Double2 o = all<Double2>(origin);
  Double2 reach = {0.0, 0.0};
  for (int i = 0; i < 8; i += 2) {
    const Double2 shifted = load(&from[i]) - o;
    store(shifted, &to[i]);
    reach = greatest(reach, magnitude(shifted));
  }
  return reach;
}

void transform(const WorldVertices& v, const Matrix3& R, const Vector3& p, int row,
               std::array<double, 8>& to) {
  const Double2 x = all<Double2>(R(row, 0)), y = all<Double2>(R(row, 1)), z = all<Double2>(R(row, 2));
  const Double2 o = all<Double2>(p(row));
  for (int i = 0; i < 8; i += 2) {
    const Double2 t = ((x * load(&v.x[i]) + y * load(&v.y[i])) + z * load(&v.z[i])) + o;
    store(t, &to[i]);
  }
}

}  // namespace

WorldVertices in_columns(const Hexahedron& solid) {
  WorldVertices out;
  for (int i = 0; i < 8; ++i) {
    const Vector3& v = solid.vertices()[i];
    out.x[i] = v.x(), out.y[i] = v.y(), out.z[i] = v.z();
  }
  return out;
}

void world_vertices(const WorldVertices& vertices_S, const Pose& X_WS, WorldVertices& out) {
  transform(vertices_S, X_WS.R, X_WS.p, 0, out.x);
  transform(vertices_S, X_WS.R, X_WS.p, 1, out.y);
  transform(vertices_S, X_WS.R, X_WS.p, 2, out.z);
}

void shift_to_common_origin(const WorldVertices& a_W, const WorldVertices& b_W, HullPair& pair) {
  const Vector3 origin = a_W.vertex(0);
  const Double2 x = greatest(shift(a_W.x, origin.x(), pair.a.x), shift(b_W.x, origin.x(), pair.b.x));
  const Double2 y = greatest(shift(a_W.y, origin.y(), pair.a.y), shift(b_W.y, origin.y(), pair.b.y));
  const Double2 z = greatest(shift(a_W.z, origin.z(), pair.a.z), shift(b_W.z, origin.z(), pair.b.z));
  const Double2 reach = greatest(greatest(x, y), z);
  pair.extent = std::max(reach[0], reach[1]);
}

Interval project(const WorldVertices& vertices, const Vector3& axis) {
  const Lanes p = dots(vertices, axis);
  return {low_of(p), high_of(p)};
}

Support support_high(const WorldVertices& vertices, const Vector3& axis) {
  const Lanes p = dots(vertices, axis);
  const double value = high_of(p);
  return {first_equal(p, value), value};
}

Support support_low(const WorldVertices& vertices, const Vector3& axis) {
  const Lanes p = dots(vertices, axis);
  const double value = low_of(p);
  return {first_equal(p, value), value};
}

}  // namespace touchstone::native
