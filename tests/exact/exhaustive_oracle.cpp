#include "touchstone/tests/exact/exhaustive_oracle.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace touchstone::exact_test {
namespace {

using Number = mpz_class;
using V = std::array<Number, 3>;

V minus(const V& u, const V& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
Number dot(const V& u, const V& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
V cross(const V& u, const V& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

// Every finite double times 2^1074 is an integer; trailing zero bits are divided out again below.
Number scaled(double value) {
  mpq_class q(value);
  q *= mpq_class(Number(1) << 1074);
  return q.get_num();
}

struct Solids {
  std::vector<V> a, b;
  mp_bitcnt_t zeros = 1074;  // coordinate = integer * 2^(zeros - 1074)
};

Solids integers(const WorldVertices& a, const WorldVertices& b) {
  Solids s;
  for (int i = 0; i < 8; ++i) {
    s.a.push_back({scaled(a.x[i]), scaled(a.y[i]), scaled(a.z[i])});
    s.b.push_back({scaled(b.x[i]), scaled(b.y[i]), scaled(b.z[i])});
  }
  s.zeros = std::numeric_limits<mp_bitcnt_t>::max();
  for (const auto* solid : {&s.a, &s.b}) {
    for (const V& v : *solid) {
      for (const Number& c : v) {
        if (c != 0) s.zeros = std::min(s.zeros, mpz_scan1(c.get_mpz_t(), 0));
      }
    }
  }
  if (s.zeros == std::numeric_limits<mp_bitcnt_t>::max()) s.zeros = 0;
  for (auto* solid : {&s.a, &s.b}) {
    for (V& v : *solid) {
      for (Number& c : v) c >>= s.zeros;
    }
  }
  return s;
}

std::vector<V> edges_of(const std::vector<V>& solid) {
  std::vector<V> edges;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) edges.push_back(minus(solid[j], solid[i]));
  }
  return edges;
}

std::vector<V> directions(const Solids& s) {
  std::vector<V> out;
  const std::vector<V> edges_a = edges_of(s.a), edges_b = edges_of(s.b);
  const auto both_ways = [&](const V& n) {
    out.push_back(n);
    out.push_back({-n[0], -n[1], -n[2]});
  };
  // Normals of faces, from two edges of one solid.
  for (const auto* edges : {&edges_a, &edges_b}) {
    for (std::size_t i = 0; i < edges->size(); ++i) {
      for (std::size_t j = i + 1; j < edges->size(); ++j) both_ways(cross((*edges)[i], (*edges)[j]));
    }
  }
  // Edge against edge.
  for (const V& e : edges_a) {
    for (const V& f : edges_b) both_ways(cross(e, f));
  }
  // Corner against corner, and corner against edge.
  for (const V& p : s.a) {
    for (const V& q : s.b) {
      const V m = minus(q, p);
      out.push_back(m);
      for (const V& axis : {V{1, 0, 0}, V{0, 1, 0}, V{0, 0, 1}}) both_ways(cross(m, axis));
      for (const auto* edges : {&edges_a, &edges_b}) {
        for (const V& e : *edges) out.push_back(cross(e, cross(m, e)));
      }
    }
  }
  // Edges against the axes, for solids that are flat there.
  for (const auto* edges : {&edges_a, &edges_b}) {
    for (const V& e : *edges) {
      for (const V& axis : {V{1, 0, 0}, V{0, 1, 0}, V{0, 0, 1}}) both_ways(cross(e, axis));
    }
  }
  return out;
}

Number height(const Solids& s, const V& n) {
  Number low = dot(s.b[0], n), high = dot(s.a[0], n);
  for (int i = 1; i < 8; ++i) {
    low = std::min(low, dot(s.b[i], n));
    high = std::max(high, dot(s.a[i], n));
  }
  return low - high;
}

// sign(value)^2 / |n|^2 keeps the order of the signed distances.
mpq_class signed_square(const Number& h, const Number& nn) {
  mpq_class result(h * abs(h), nn);
  result.canonicalize();
  return result;
}

mpq_class midpoint_square(double u, double v) {
  const mpq_class middle = (mpq_class(u) + mpq_class(v)) / 2;
  return middle * abs(middle);
}

}  // namespace

bool is_signed_distance(const WorldVertices& a, const WorldVertices& b, double separation) {
  const Solids s = integers(a, b);
  bool found = false;
  Number best_h = 0, best_nn = 1;
  for (const V& n : directions(s)) {
    const Number nn = dot(n, n);
    if (nn == 0) continue;
    const Number h = height(s, n);
    // h / |n| > best_h / |best|
    const Number mine = h * abs(h) * best_nn, theirs = best_h * abs(best_h) * nn;
    if (!found || mine > theirs) {
      best_h = h;
      best_nn = nn;
    }
    found = true;
  }
  mpq_class square = signed_square(best_h, best_nn);  // times 4^(zeros - 1074) in metres
  square *= mpq_class(Number(1) << (2 * s.zeros));
  square /= mpq_class(Number(1) << (2 * 1074));
  if (sgn(square) == 0) return separation == 0.0;
  if (!std::isfinite(separation)) return false;
  return midpoint_square(std::nextafter(separation, -kInfinity), separation) <= square &&
         square <= midpoint_square(separation, std::nextafter(separation, kInfinity));
}

}  // namespace touchstone::exact_test
