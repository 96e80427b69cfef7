#include "contact_core/native/hull_pair.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::native {
namespace {

// Two lanes: what every x86-64 and arm64 has. Lanes never mix, so the bits are those of scalar code.
typedef double Double2 __attribute__((vector_size(16)));

struct Dots {
  Double2 d[4];
};

Double2 load(const double* p) { return Double2{p[0], p[1]}; }

Dots dots(const WorldVertices& v, const Vector3& axis) {
  const Double2 x = {axis.x(), axis.x()}, y = {axis.y(), axis.y()}, z = {axis.z(), axis.z()};
  Dots out;
  for (int i = 0; i < 4; ++i)
    out.d[i] = (x * load(&v.x[2 * i]) + y * load(&v.y[2 * i])) + z * load(&v.z[2 * i]);
  return out;
}

Double2 least(Double2 p, Double2 q) { return p < q ? p : q; }
Double2 greatest(Double2 p, Double2 q) { return p > q ? p : q; }

int first_equal(const Dots& dots_of, double value) {
  for (int i = 0; i < 7; ++i)
    if (dots_of.d[i / 2][i % 2] == value) return i;
  return 7;
}

double low_of(const Dots& p) {
  const Double2 m = least(least(p.d[0], p.d[1]), least(p.d[2], p.d[3]));
  return m[0] < m[1] ? m[0] : m[1];
}

double high_of(const Dots& p) {
  const Double2 m = greatest(greatest(p.d[0], p.d[1]), greatest(p.d[2], p.d[3]));
  return m[0] > m[1] ? m[0] : m[1];
}

double largest_of(const std::array<double, 8>& values) {
  double largest = 0.0;
  for (double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

}  // namespace

void shift_to_common_origin(const WorldVertices& a_W, const WorldVertices& b_W, HullPair& pair) {
  const Vector3 origin = a_W.vertex(0);
  for (int i = 0; i < 8; ++i) {
    pair.a.x[i] = a_W.x[i] - origin.x(), pair.b.x[i] = b_W.x[i] - origin.x();
    pair.a.y[i] = a_W.y[i] - origin.y(), pair.b.y[i] = b_W.y[i] - origin.y();
    pair.a.z[i] = a_W.z[i] - origin.z(), pair.b.z[i] = b_W.z[i] - origin.z();
  }
  pair.extent = std::max({largest_of(pair.a.x), largest_of(pair.a.y), largest_of(pair.a.z),
                          largest_of(pair.b.x), largest_of(pair.b.y), largest_of(pair.b.z)});
}

Interval project(const WorldVertices& vertices, const Vector3& axis) {
  const Dots p = dots(vertices, axis);
  return {low_of(p), high_of(p)};
}

Support support_high(const WorldVertices& vertices, const Vector3& axis) {
  const Dots p = dots(vertices, axis);
  const double value = high_of(p);
  return {first_equal(p, value), value};
}

Support support_low(const WorldVertices& vertices, const Vector3& axis) {
  const Dots p = dots(vertices, axis);
  const double value = low_of(p);
  return {first_equal(p, value), value};
}

}  // namespace touchstone::native
