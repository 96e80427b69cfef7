#include "touchstone/contact_core/native/distance/distance.hpp"

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/common/double_double.hpp"
#include "touchstone/contact_core/native/common/lanes.hpp"
#include "touchstone/contact_core/native/distance/facet_axes.hpp"
#include "touchstone/contact_core/native/distance/witness.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"

namespace touchstone::native {
namespace {

/// Below this share of the extent, u * extent / |v| costs the normal more than 2^6 u, and v is recomputed.
constexpr double kShort = 0x1p-6;
/// Upper and lower bound must agree to this many u * extent.
constexpr double kGap = 16;

/// Vertices that extend() may add to a search that stopped short.
constexpr int kExtensions = 3;

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

/// The same for an edge: a simplex of two vertices.
bool recompute_on_edge(const HullPair& hulls, Simplex& s, SignedDistance& out) {
  DoubleDouble3 v;
  if (!foot_on_edge(minkowski_vertex(hulls, s, 0), minkowski_vertex(hulls, s, 1), s, v)) return false;
  const Vector3 direction = v.rounded();
  const double length = norm(direction);
  if (!(length > 0.0)) return false;
  out.separation = length;
  out.n = direction / length;
  return true;
}

/// Where the foot lies on a triangle's rim, rounding puts it on either side: the nearest edge has it.
bool recompute_on_rim(const HullPair& hulls, Simplex& s, SignedDistance& out) {
  Simplex best;
  SignedDistance nearest{kInfinity, {}, {}};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    Simplex edge = s;
    edge.count = 2;
    edge.a = {s.a[i], s.a[j]}, edge.b = {s.b[i], s.b[j]};
    edge.w[0] = s.w[i], edge.w[1] = s.w[j];
    SignedDistance distance = out;
    if (!recompute_on_edge(hulls, edge, distance) || !(distance.separation < nearest.separation)) continue;
    best = edge, nearest = distance;
  }
  if (best.count == 0) return false;
  s = best, out = nearest;
  return true;
}

bool recompute(const HullPair& hulls, Simplex& s, SignedDistance& out) {
  const DoubleDouble3 w0 = minkowski_vertex(hulls, s, 0);
  if (s.count == 3)
    return foot_on_triangle(w0, minkowski_vertex(hulls, s, 1), minkowski_vertex(hulls, s, 2), s, out) ||
           recompute_on_rim(hulls, s, out);
  if (s.count == 2) return recompute_on_edge(hulls, s, out);
  const Vector3 direction = w0.rounded();
  const double length = norm(direction);
  if (!(length > 0.0)) return false;
  out.separation = length;
  out.n = direction / length;
  return true;
}

bool agrees(const HullPair& hulls, const SignedDistance& d) {
  return d.separation - separation_along(hulls, d.n) <= kGap * kRoundoff * hulls.extent;
}

/// Replaces one of three vertices by the one furthest against out.n, for searches that stopped on a face's
/// diagonal, which the foot misses by a rounding. False when there is no such vertex or it is no better.
bool extend(const HullPair& hulls, Simplex& s, SignedDistance& out) {
  const auto a = static_cast<std::uint8_t>(support_high(hulls.a, out.n).index);
  const auto b = static_cast<std::uint8_t>(support_low(hulls.b, out.n).index);
  for (int i = 0; i < s.count; ++i)
    if (s.a[i] == a && s.b[i] == b) return false;
  const auto put = [&](int i, Simplex& to) {
    to.a[i] = a, to.b[i] = b;
    to.w[i] = hulls.b.vertex(b) - hulls.a.vertex(a);
  };
  if (s.count < 3) {
    put(s.count++, s);
    return recompute(hulls, s, out);
  }
  for (int i = 0; i < 3; ++i) {
    Simplex other = s;
    put(i, other);
    SignedDistance distance = out;
    if (!recompute(hulls, other, distance) || !agrees(hulls, distance)) continue;
    s = other, out = distance;
    return true;
  }
  return false;
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

/// Whether the foot of p on the line through `from` and `to` is certainly not between them, or separates the
/// hulls by less than the best direction does. With M the extent, vectors between vertices are at most 3.5 M
/// long, their product with the edge e is off by 18 u M |e| and e^2 by as much; so the foot's place along the
/// edge by 40 u M, and v by less than 64 u M. That turns v by at most 128 u M / |v|, which moves the
/// separation by 448 u M^2 / |v|; evaluating it adds 24 u M.
bool is_certainly_no_better(const Vector3& p, const Vector3& from, const Vector3& to, double sign,
                            const BestDirection& directions) {
  const double u_extent = kRoundoff * directions.hulls.extent;
  const Vector3 w = from - p, e = to - from;
  const double along = -dot(w, e), length2 = dot(e, e), margin = 64 * u_extent * norm_1(e);
  if (along < -margin || along - length2 > margin) return true;
  const Vector3 v = w + (along / length2) * e;
  const double length = norm(v);
  const double error = 1024 * u_extent * (directions.hulls.extent / length);
  const Vector3 n = (sign / length) * v;
  const double separation = low_of(dots(directions.hulls.b, n)) - high_of(dots(directions.hulls.a, n));
  return separation + error < directions.best.separation;
}

void consider_vertex_and_edge(const Vector3& p, const Vector3& from, const Vector3& to, double sign,
                              BestDirection& directions) {
  if (is_certainly_no_better(p, from, to, sign, directions)) return;
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

bool separated_distance(const PosedPair& pair, double limit, SignedDistance& result) {
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
    for (int i = 0; i < kExtensions && known && !agrees(pair.hulls, result); ++i)
      known = extend(pair.hulls, s, result);
    if (known && agrees(pair.hulls, result)) {
      result.p_A = point_on_a(pair.hulls, s);
      return true;
    }
  }
  const SeparationAxis axis = search_all_features(pair);
  result = {axis.separation, axis.n, witness_along(pair, axis.separation, axis.n).p_A};
  return true;
}

}  // namespace touchstone::native
