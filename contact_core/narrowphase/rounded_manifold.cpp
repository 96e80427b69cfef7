#include "touchstone/contact_core/narrowphase/rounded_manifold.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {
namespace {

/// sqrt(1 - kManifoldCosine^2), rounded down.
constexpr double kManifoldSine = 0.0447;

/// Two quadrilaterals clipped have eight corners at most.
constexpr int kMostCorners = 8;

/// The feature that supports a core along a direction: corners of a vertex, an edge or a face, in order.
struct Feature {
  std::array<Vector3, kMostCorners> corners;
  int count = 0;
  std::uint32_t id = 0;              ///< 0-5 a face, 6-17 an edge, 18-25 a vertex
  Vector3 normal = Vector3::Zero();  ///< of a face, unit
};

Vector3 unit_or_zero(const Vector3& v) {
  const double length = norm(v);
  return length > 0.0 ? Vector3(v / length) : Vector3::Zero();
}

bool find_face(const WorldVertices& v, const Vector3& n, Feature& out) {
  double best = kManifoldCosine;
  for (std::uint32_t f = 0; f < 6; ++f) {
    const auto& quad = Hexahedron::kFaceVertices[f];
    const Vector3 diagonal = v.vertex(quad[2]) - v.vertex(quad[0]);
    const Vector3 normal = unit_or_zero(cross(diagonal, v.vertex(quad[3]) - v.vertex(quad[1])));
    if (!(dot(normal, n) >= best)) continue;
    best = dot(normal, n);
    out.id = f, out.count = 4, out.normal = normal;
    for (std::size_t k = 0; k < 4; ++k) out.corners[k] = v.vertex(quad[k]);
  }
  return out.count > 0;
}

/// An edge that holds the support vertex and lies flat against n.
bool find_edge(const WorldVertices& v, const Vector3& n, const Vector3& highest, Feature& out) {
  double flattest = kManifoldSine;
  for (std::uint32_t e = 0; e < 12; ++e) {
    const Vector3 from = v.vertex(Hexahedron::kEdgeVertices[e][0]);
    const Vector3 to = v.vertex(Hexahedron::kEdgeVertices[e][1]);
    const double length = norm(to - from);
    if (!(length > 0.0) || (from != highest && to != highest)) continue;
    const double slope = std::abs(dot(to - from, n)) / length;
    if (!(slope <= flattest) || (out.count > 0 && slope == flattest)) continue;
    flattest = slope;
    out.id = 6 + e, out.count = 2;
    out.corners[0] = from, out.corners[1] = to;
  }
  return out.count > 0;
}

Feature find_feature(const WorldVertices& v, const Vector3& n) {
  Feature out;
  if (find_face(v, n, out)) return out;
  int highest = 0;
  for (int i = 1; i < Hexahedron::kVertices; ++i)
    if (dot(v.vertex(i), n) > dot(v.vertex(highest), n)) highest = i;
  if (find_edge(v, n, v.vertex(highest), out)) return out;
  out.id = 18 + static_cast<std::uint32_t>(highest), out.count = 1;
  out.corners[0] = v.vertex(highest);
  return out;
}

/// Keeps the part of `subject` (a polygon, an edge or a vertex) that is over the face, seen along n.
void clip(const Feature& face, const Vector3& n, Feature& subject) {
  // Against -n for B's face: its corners then run the other way round.
  const double turn = dot(face.normal, n) > 0.0 ? 1.0 : -1.0;
  for (int k = 0; k < face.count; ++k) {
    const Vector3& corner = face.corners[static_cast<std::size_t>(k)];
    const Vector3 along = face.corners[static_cast<std::size_t>((k + 1) % face.count)] - corner;
    const Vector3 inwards = turn * cross(n, along);
    const auto height = [&](const Vector3& p) { return dot(inwards, p - corner); };
    Feature kept = subject;
    kept.count = 0;
    const auto put = [&kept](const Vector3& p) {
      if (kept.count < kMostCorners) kept.corners[static_cast<std::size_t>(kept.count++)] = p;
    };
    const int edges = subject.count == 2 ? 1 : subject.count;  // an edge is no ring
    for (int i = 0; i < subject.count; ++i) {
      const Vector3& p = subject.corners[static_cast<std::size_t>(i)];
      const double at_p = height(p);
      if (at_p >= 0.0) put(p);
      if (i >= edges || subject.count == 1) continue;
      const Vector3& q = subject.corners[static_cast<std::size_t>((i + 1) % subject.count)];
      const double at_q = height(q);
      if ((at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0)) put(p + (at_p / (at_p - at_q)) * (q - p));
    }
    subject = kept;
  }
}

/// Points of both cores over each other along n.
struct CorePoints {
  std::array<Vector3, kMostCorners> on_a, on_b;
  int count = 0;
};

CorePoints over_face(const Feature& face, Feature subject, const Vector3& n, bool face_is_a) {
  clip(face, n, subject);
  CorePoints out;
  out.count = subject.count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(subject.count); ++i) {
    const Vector3& p = subject.corners[i];
    const double drop = dot(face.normal, p - face.corners[0]) / dot(face.normal, n);
    const Vector3 on_face = p - drop * n;
    out.on_a[i] = face_is_a ? on_face : p;
    out.on_b[i] = face_is_a ? p : on_face;
  }
  return out;
}

/// Where two edges run along each other: the ends of what they share, as far as one is over the other to
/// kManifoldSine of the lesser radius.
CorePoints along_edges(const Feature& a, const Feature& b, const Vector3& n, double lesser_radius) {
  CorePoints out;
  const Vector3 axis = a.corners[1] - a.corners[0];
  const double square = dot(axis, axis);
  const Vector3 other = b.corners[1] - b.corners[0];
  const double run = dot(other, axis) / square;
  if (run == 0.0) return out;
  const double first = dot(b.corners[0] - a.corners[0], axis) / square;
  const double low = std::max(0.0, std::min(first, first + run));
  const double high = std::min(1.0, std::max(first, first + run));
  if (!(low < high)) return out;
  for (const double t : {low, high}) {
    const Vector3 p = a.corners[0] + t * axis;
    const Vector3 q = b.corners[0] + ((t - first) / run) * other;
    const Vector3 aside = (q - p) - dot(q - p, n) * n;
    if (!(norm(aside) <= kManifoldSine * lesser_radius)) {
      out.count = 0;
      return out;
    }
    const auto slot = static_cast<std::size_t>(out.count++);
    out.on_a[slot] = p, out.on_b[slot] = q;
  }
  return out;
}

CorePoints core_points(const Feature& a, const Feature& b, const Vector3& n, double lesser_radius) {
  if (a.count == 4) return over_face(a, b, n, true);
  if (b.count == 4) return over_face(b, a, n, false);
  if (a.count == 2 && b.count == 2) return along_edges(a, b, n, lesser_radius);
  return {};
}

/// The deepest first, then always the one furthest from those chosen.
/// @param is_swapped the distance is that on B.
int choose(std::span<ContactPoint> from, std::size_t most, bool is_swapped) {
  const auto deeper = [](const ContactPoint& p, const ContactPoint& q) {
    return p.separation < q.separation;
  };
  std::iter_swap(from.begin(), std::min_element(from.begin(), from.end(), deeper));
  for (std::size_t chosen = 1; chosen < most; ++chosen) {
    std::size_t best = chosen;
    double furthest = -1.0;
    for (std::size_t i = chosen; i < from.size(); ++i) {
      double nearest = kInfinity;
      for (std::size_t k = 0; k < chosen; ++k)
        nearest = std::min(nearest,
                           norm(is_swapped ? from[i].p_B_W - from[k].p_B_W : from[i].p_A_W - from[k].p_A_W));
      if (nearest > furthest) furthest = nearest, best = i;
    }
    std::swap(from[chosen], from[best]);
  }
  return static_cast<int>(most);
}

/// By radius, then by the vertices' coordinates: the same whichever solid is named first.
bool comes_before(const RoundedHull& a, const RoundedHull& b) {
  if (a.radius != b.radius) return a.radius < b.radius;
  if (a.core_W.x != b.core_W.x) return a.core_W.x < b.core_W.x;
  return a.core_W.y != b.core_W.y ? a.core_W.y < b.core_W.y : a.core_W.z < b.core_W.z;
}

/// The solids, and their geometry, in the order in which points are found.
struct OrderedPair {
  const RoundedHull &a, &b;
  Vector3 n, p_A, p_B;
  double separation;
  bool is_swapped;

  OrderedPair(const RoundedHull& first, const RoundedHull& second, const PairGeometry& geometry, bool swapped)
      : a(swapped ? second : first),
        b(swapped ? first : second),
        n(swapped ? Vector3(-geometry.n_AB_W) : geometry.n_AB_W),
        p_A(swapped ? geometry.p_B_W : geometry.p_A_W),
        p_B(swapped ? geometry.p_A_W : geometry.p_B_W),
        separation(geometry.separation),
        is_swapped(swapped) {}

  ContactPoint point(const Vector3& on_a, const Vector3& on_b, double apart, std::uint32_t id) const {
    return is_swapped ? ContactPoint{on_b, on_a, apart, id} : ContactPoint{on_a, on_b, apart, id};
  }
};

}  // namespace

void grow_by_radii(double radius_a, double radius_b, PairGeometry& geometry) {
  geometry.separation -= radius_a + radius_b;
  geometry.p_A_W += radius_a * geometry.n_AB_W;
  geometry.p_B_W -= radius_b * geometry.n_AB_W;
}

int find_rounded_points(const RoundedHull& a, const RoundedHull& b, const PairGeometry& geometry,
                        const Query& query, std::span<ContactPoint> points) {
  const OrderedPair pair(a, b, geometry, comes_before(b, a));
  const Vector3& n = pair.n;
  const Feature on_a = find_feature(pair.a.core_W, n), on_b = find_feature(pair.b.core_W, -n);
  const CorePoints cores = core_points(on_a, on_b, n, std::min(a.radius, b.radius));
  // Rounding of clip, drop and radii: a few u of the largest coordinate.
  const double reach = norm_inf(geometry.p_A_W) + norm_inf(geometry.p_B_W) + (a.radius + b.radius);
  double extent = 0.0;
  for (int i = 0; i < cores.count; ++i)
    extent = std::max(extent, norm_inf(cores.on_a[static_cast<std::size_t>(i)] - pair.p_A));
  const double slack = 128 * std::numeric_limits<double>::epsilon() * (reach + extent);
  const double limit = point_limit(query, pair.separation) + slack;
  // Corners within the limit become points; the deepest have the pair's own separation.
  const std::uint32_t first_id = pair.is_swapped ? on_b.id : on_a.id;
  const std::uint32_t second_id = pair.is_swapped ? on_a.id : on_b.id;
  std::array<ContactPoint, kMostCorners + 1> found;
  std::size_t count = 0;
  bool as_deep = false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(cores.count); ++i) {
    const double apart = dot(cores.on_b[i] - cores.on_a[i], n) - (a.radius + b.radius);
    if (!(apart <= limit)) continue;
    const bool deepest = apart <= pair.separation + slack;
    const double separation = deepest ? pair.separation : apart;
    const Vector3 p_A = cores.on_a[i] + pair.a.radius * n;
    as_deep = as_deep || deepest;
    const std::uint32_t id = 1 + ((first_id << 10) | (second_id << 5) | static_cast<std::uint32_t>(i));
    found[count++] = pair.point(p_A, p_A + separation * n, separation, id);
  }
  // The witness points where no corner is as deep; then the choice.
  if (!as_deep) found[count++] = pair.point(pair.p_A, pair.p_B, pair.separation, 0);
  const auto most = std::min(count, static_cast<std::size_t>(query.max_points));
  const int written = choose(std::span(found).first(count), most, pair.is_swapped);
  std::copy_n(found.begin(), written, points.begin());
  return written;
}

}  // namespace touchstone
