#include "touchstone/tests/native/distance/all_features_reference.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace touchstone {
namespace {

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Wide;  // long double has 64 bits on x86-64, 113 on arm64
#else
using Wide = long double;
#endif

template <class Real>
struct Vector {
  Real x, y, z;

  template <class Other>
  Vector<Other> as() const {
    return {static_cast<Other>(x), static_cast<Other>(y), static_cast<Other>(z)};
  }
  friend Vector operator-(const Vector& p, const Vector& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
  friend Vector operator*(Real s, const Vector& p) { return {s * p.x, s * p.y, s * p.z}; }
  friend Real dot(const Vector& p, const Vector& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }
  friend Vector cross(const Vector& p, const Vector& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  }
};
using V = Vector<long double>;

std::vector<V> points(const WorldVertices& v, const WorldVertices& origin) {
  std::vector<V> out;
  for (int i = 0; i < 8; ++i)
    out.push_back({static_cast<long double>(v.x[i]) - origin.x[0],
                   static_cast<long double>(v.y[i]) - origin.y[0],
                   static_cast<long double>(v.z[i]) - origin.z[0]});
  return out;
}

struct Reference {
  std::vector<V> a, b;
  long double best = -std::numeric_limits<long double>::infinity();

  void consider(const V& axis) {
    const long double length = std::sqrt(dot(axis, axis));
    if (!(length > 0)) return;
    long double a_low = INFINITY, a_high = -INFINITY, b_low = INFINITY, b_high = -INFINITY;
    for (int i = 0; i < 8; ++i) {
      const long double p = dot(axis, a[i]), q = dot(axis, b[i]);
      a_low = std::min(a_low, p), a_high = std::max(a_high, p), b_low = std::min(b_low, q),
      b_high = std::max(b_high, q);
    }
    best = std::max(best, std::max(b_low - a_high, a_low - b_high) / length);
  }

  void consider_line(const V& p, const V& from, const V& to) {
    // Wide: the foot's direction cancels when p is close to the line.
    const Vector<Wide> e = to.as<Wide>() - from.as<Wide>(), w = from.as<Wide>() - p.as<Wide>();
    const Wide square = dot(e, e);
    if (square > 0) consider((w - (dot(w, e) / square) * e).as<long double>());
  }
};

}  // namespace

long double reference_signed_distance(const WorldVertices& a, const WorldVertices& b) {
  Reference r{points(a, a), points(b, a)};
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      r.consider(r.b[j] - r.a[i]);
      for (int k = j + 1; k < 8; ++k) {
        if (j > i) r.consider(cross(r.a[j] - r.a[i], r.a[k] - r.a[i]));
        if (j > i) r.consider(cross(r.b[j] - r.b[i], r.b[k] - r.b[i]));
        r.consider_line(r.a[i], r.b[j], r.b[k]);
        r.consider_line(r.b[i], r.a[j], r.a[k]);
        for (int l = i + 1; l < 8; ++l) r.consider(cross(r.a[l] - r.a[i], r.b[k] - r.b[j]));
      }
    }
  }
  return r.best;
}

long double reference_separation_along(const WorldVertices& a, const WorldVertices& b, const Vector3& n) {
  const std::vector<V> p = points(a, a), q = points(b, a);
  const V axis{n.x(), n.y(), n.z()};
  long double high = -INFINITY, low = INFINITY;
  for (int i = 0; i < 8; ++i) high = std::max(high, dot(axis, p[i])), low = std::min(low, dot(axis, q[i]));
  return low - high;
}

long double reference_height(const WorldVertices& hull, const Vector3& p) {
  const std::vector<V> v = points(hull, hull);
  const V point{static_cast<long double>(p.x()) - hull.x[0], static_cast<long double>(p.y()) - hull.y[0],
                static_cast<long double>(p.z()) - hull.z[0]};
  long double best = -INFINITY;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = j + 1; k < 8; ++k) {
        const V axis = cross(v[j] - v[i], v[k] - v[i]);
        const long double length = std::sqrt(dot(axis, axis));
        if (!(length > 1e-12L)) continue;
        for (const long double sign : {1.0L, -1.0L}) {
          long double high = -INFINITY;
          for (const V& q : v) high = std::max(high, sign * dot(axis, q));
          best = std::max(best, (sign * dot(axis, point) - high) / length);
        }
      }
  return best;
}

}  // namespace touchstone
