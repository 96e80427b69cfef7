#include "contact_core/native/manifold.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/native/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// A face leaning more than this against n is seen edge-on: a projection along n would stretch rounding by
/// its inverse.
constexpr double kEdgeOn = 0x1p-10;
/// Corners closer than this share of the extent are one corner.
constexpr double kSameCorner = 0x1p-44;
/// On an edge, or as deep as the deepest point, to rounding: so many u * extent.
constexpr double kOnEdge = 16;
constexpr double kAsDeep = 64;
constexpr double kSameArea = 1e-9;
constexpr std::uint32_t kWitnessId = 0x10000;
constexpr int kMaxCorners = 16;

struct Corner {
  double x = 0.0, y = 0.0;
  int edge = 0;      // label of the polygon edge that starts here
  int previous = 0;  // label of the one that ends here
};

struct Polygon {
  int count = 0;
  std::array<Corner, kMaxCorners> corners;

  void add(const Corner& corner) {
    if (count < kMaxCorners) corners[count++] = corner;
  }
};

struct ProjectedFace {
  int index = -1;
  double lean = 0.0;  // normal . n
  Vector3 normal;     // outward, unit, world
  Vector3 anchor;     // a vertex
  Polygon outline;    // counter-clockwise seen against n
};

/// @param sign +1: the face that looks along n; -1: against.
ProjectedFace face_towards(const SolidFeatures& features, const Matrix3& R, const WorldVertices& vertices,
                           const TangentFrame& frame, double sign, int first_label) {
  ProjectedFace best;
  const Matrix3 N = cofactor(R);
  for (int f = 0; f < features.face_count; ++f) {
    const Vector3 rotated = rotate(N, features.faces[f].normal);
    const Vector3 normal = rotated / norm(rotated);
    const double lean = sign * dot(normal, frame.n);
    if (best.index >= 0 && !(lean > best.lean + 4 * kRoundoff)) continue;
    best.index = f, best.lean = lean, best.normal = normal;
  }
  const HullFace& face = features.faces[best.index];
  best.anchor = vertices.vertex(face.vertices[0]);
  for (int i = 0; i < face.count; ++i) {
    const int k = sign > 0.0 ? i : face.count - 1 - i;
    const int before = (i + face.count - 1) % face.count;
    const Vector3 p = vertices.vertex(face.vertices[k]);
    best.outline.add({dot(p, frame.x), dot(p, frame.y), first_label + i, first_label + before});
  }
  return best;
}

/// What of `polygon` lies left of the line from p to q.
Polygon clipped(const Polygon& polygon, const Corner& p, const Corner& q, double tolerance) {
  const double ex = q.x - p.x, ey = q.y - p.y;
  const double length = std::sqrt(ex * ex + ey * ey);
  if (!(length > 0.0)) return polygon;
  std::array<double, kMaxCorners> side{};
  for (int i = 0; i < polygon.count; ++i) {
    const Corner& c = polygon.corners[i];
    side[i] = (ex * (c.y - p.y) - ey * (c.x - p.x)) / length;
  }
  Polygon out;
  for (int i = 0; i < polygon.count; ++i) {
    const int next = (i + 1) % polygon.count;
    const Corner& c = polygon.corners[i];
    const Corner& d = polygon.corners[next];
    const bool inside = side[i] >= -tolerance, next_inside = side[next] >= -tolerance;
    if (inside) out.add(c);
    if (inside == next_inside) continue;
    const double t = side[i] / (side[i] - side[next]);
    const double x = c.x + t * (d.x - c.x), y = c.y + t * (d.y - c.y);
    if (inside)
      out.add({x, y, p.edge, c.edge});
    else
      out.add({x, y, c.edge, p.edge});
  }
  return out;
}

Polygon without_repeats(const Polygon& polygon, double tolerance) {
  Polygon out;
  const auto same = [tolerance](const Corner& c, const Corner& d) {
    return std::abs(c.x - d.x) <= tolerance && std::abs(c.y - d.y) <= tolerance;
  };
  for (int i = 0; i < polygon.count; ++i) {
    const Corner& c = polygon.corners[i];
    if (out.count > 0 && same(out.corners[out.count - 1], c)) continue;
    if (i + 1 == polygon.count && out.count > 0 && same(out.corners[0], c)) continue;
    out.add(c);
  }
  return out;
}

/// Height along n at which the line through (x, y) meets the face's plane.
double height_on(const ProjectedFace& face, const TangentFrame& frame, const Vector3& p) {
  return dot(face.normal, face.anchor - p) / dot(face.normal, frame.n);
}

struct Candidates {
  int count = 0;
  std::array<ContactPoint, kMaxCorners + 1> points;
  std::array<double, kMaxCorners + 1> x{}, y{};
  int corners = 0;  // the first so many are the clip's, in order
};

double twice_area(const Candidates& c, const std::array<int, kMaxManifoldPoints>& chosen, int count) {
  double area = 0.0;
  for (int i = 1; i + 1 < count; ++i) {
    const int p = chosen[0], q = chosen[i], r = chosen[i + 1];
    area += (c.x[q] - c.x[p]) * (c.y[r] - c.y[p]) - (c.y[q] - c.y[p]) * (c.x[r] - c.x[p]);
  }
  return area;
}

double square_distance(const Candidates& c, int i, int j) {
  const double x = c.x[i] - c.x[j], y = c.y[i] - c.y[j];
  return x * x + y * y;
}

/// Whether a choice of corners (in clip order) beats another: by area; two points by their distance.
double worth(const Candidates& c, const std::array<int, kMaxManifoldPoints>& chosen, int count) {
  return count == 2 ? square_distance(c, chosen[0], chosen[1]) : twice_area(c, chosen, count);
}

/// Tries every choice of `count` of the corners that has `must` among them (if must is a corner).
void choose(const Candidates& c, int must, int count, int from, int taken,
            std::array<int, kMaxManifoldPoints>& current, double& best_worth,
            std::array<int, kMaxManifoldPoints>& best) {
  if (taken == count) {
    const bool has_must = must >= c.corners || std::find(current.begin(), current.begin() + count, must) !=
                                                   current.begin() + count;
    if (!has_must) return;
    const double value = worth(c, current, count);
    if (best_worth < 0.0 || value > best_worth * (1.0 + kSameArea)) best_worth = value, best = current;
    return;
  }
  for (int i = from; i <= c.corners - (count - taken); ++i) {
    current[taken] = i;
    choose(c, must, count, i + 1, taken + 1, current, best_worth, best);
  }
}

void reduce(const Candidates& c, int deepest, int max_points, Manifold& manifold) {
  manifold.count = 0;
  if (max_points == 1) {
    manifold.points[manifold.count++] = c.points[deepest];
    return;
  }
  const bool extra = deepest >= c.corners;
  const int count = extra ? max_points - 1 : max_points;
  std::array<int, kMaxManifoldPoints> best{}, current{};
  double best_worth = -1.0;
  choose(c, deepest, count, 0, 0, current, best_worth, best);
  for (int i = 0; i < count; ++i) manifold.points[manifold.count++] = c.points[best[i]];
  if (extra) manifold.points[manifold.count++] = c.points[deepest];
}

/// Rounding far from the origin flattens faces to segments and points: those bound nothing to clip against.
bool has_area(const Polygon& polygon, double extent) {
  double area = 0.0, perimeter = 0.0;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner& origin = polygon.corners[0];
    const Corner& c = polygon.corners[i];
    const Corner& d = polygon.corners[(i + 1) % polygon.count];
    area += (c.x - origin.x) * (d.y - origin.y) - (c.y - origin.y) * (d.x - origin.x);
    perimeter += std::sqrt((d.x - c.x) * (d.x - c.x) + (d.y - c.y) * (d.y - c.y));
  }
  return area > kOnEdge * kRoundoff * extent * perimeter;
}

Polygon clip_of(const ProjectedFace& a, const ProjectedFace& b, double extent) {
  if (a.lean < kEdgeOn || b.lean < kEdgeOn) return {};
  if (!has_area(a.outline, extent) || !has_area(b.outline, extent)) return {};
  Polygon clip = a.outline;
  for (int i = 0; i < b.outline.count; ++i)
    clip = clipped(clip, b.outline.corners[i], b.outline.corners[(i + 1) % b.outline.count],
                   kOnEdge * kRoundoff * extent);
  return without_repeats(clip, kSameCorner * extent);
}

}  // namespace

void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_separation,
                   int max_points, Manifold& manifold) {
  const TangentFrame frame = tangent_frame(distance.n);
  const double extent = pair.hulls.extent;
  const ProjectedFace a = face_towards(*pair.a, pair.R_WA, pair.hulls.a, frame, 1.0, 0);
  const ProjectedFace b = face_towards(*pair.b, pair.R_WB, pair.hulls.b, frame, -1.0, 8);
  const Polygon clip = clip_of(a, b, extent);

  Candidates candidates;
  int deepest = -1;
  for (int i = 0; i < clip.count; ++i) {
    const Corner& corner = clip.corners[i];
    const Vector3 foot = corner.x * frame.x + corner.y * frame.y;
    const double height_a = height_on(a, frame, foot), height_b = height_on(b, frame, foot);
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    const double separation = std::max(height_b - height_a, distance.separation);
    if (separation > std::max(max_separation, distance.separation)) continue;
    const int k = candidates.count++;
    ContactPoint& point = candidates.points[k];
    point.p_A_W = foot + height_a * frame.n;
    point.p_B_W = foot + height_b * frame.n;
    point.separation = separation;
    point.feature_id =
        static_cast<std::uint32_t>(1 + corner.previous + 16 * corner.edge + 256 * a.index + 4096 * b.index);
    candidates.x[k] = corner.x, candidates.y[k] = corner.y;
    if (deepest < 0 || separation < candidates.points[deepest].separation - kAsDeep * kRoundoff * extent)
      deepest = k;
  }
  candidates.corners = candidates.count;

  const bool reached = deepest >= 0 && std::abs(candidates.points[deepest].separation -
                                                distance.separation) <= kAsDeep * kRoundoff * extent;
  if (!reached) {
    deepest = candidates.count++;
    candidates.points[deepest].p_A_W = distance.p_A;
    candidates.points[deepest].feature_id = kWitnessId;
  }
  ContactPoint& exact = candidates.points[deepest];
  exact.separation = distance.separation;
  exact.p_B_W = exact.p_A_W + distance.separation * distance.n;

  if (candidates.count > max_points) return reduce(candidates, deepest, max_points, manifold);
  manifold.count = candidates.count;
  std::copy(candidates.points.begin(), candidates.points.begin() + candidates.count, manifold.points.begin());
}

}  // namespace touchstone::native
