#include "contact_core/native/manifold.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "contact_core/native/largest_choice.hpp"
#include "contact_core/native/outline_clip.hpp"
#include "contact_core/native/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// Points this close to the deepest are as deep: so many u * extent.
constexpr double kAsDeep = 64;
constexpr std::uint32_t kWitnessId = 0x10000;

/// Contact points in the clip's order.
struct Points {
  ContactPoint* points;
  int count = 0;
  int deepest = 0;  ///< the first of those as deep as the deepest
};

/// Writes the clip's corners as contact points, those further apart than `limit` left out.
template <int N>
Points write_corners(const Clip<N>& clip, const SignedDistance& distance, double limit, double tie,
                     std::uint32_t faces, ContactPoint* points) {
  const Vector3 n = distance.n;
  Points out{points};
  std::array<double, 2 * N> separations;
  separations.fill(std::numeric_limits<double>::infinity());
  double least = limit;
  std::uint32_t before = clip.label[last_corner(clip)];
  visit_corners(clip, [&](int edge) {
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    const double s = clip.separation[edge], separation = s > distance.separation ? s : distance.separation;
    const double on_b = edge < N ? 0.0 : 1.0;
    const double to_a = -on_b * separation, to_b = (1.0 - on_b) * separation;
    const double x = clip.p_x[edge], y = clip.p_y[edge], z = clip.p_z[edge];
    const std::uint32_t label = clip.label[edge];
    ContactPoint& point = points[out.count];
    point.p_A_W = {x + to_a * n.x(), y + to_a * n.y(), z + to_a * n.z()};
    point.p_B_W = {x + to_b * n.x(), y + to_b * n.y(), z + to_b * n.z()};
    point.separation = separations[out.count] = separation;
    point.feature_id = (1 + before + 16 * label) + faces;
    before = label;
    out.count += separation <= limit ? 1 : 0;
    least = separation < least ? separation : least;
  });
  unsigned deep = 0;
  for (int k = 0; k < 2 * N; ++k) deep |= (separations[k] <= least + tie ? 1u : 0u) << k;
  out.deepest = out.count > 0 ? std::countr_zero(deep) : 0;
  return out;
}

/// Keeps `room` of the points, `must` among them unless it is negative.
void reduce(const Vector3& n, int room, int must, Points& points) {
  const TangentFrame frame = tangent_frame(n);
  FlatPolygon polygon;
  polygon.count = points.count;
  for (int i = 0; i < points.count; ++i) {
    const Vector3& p = points.points[i].p_A_W;
    polygon.x[i] = dot(p, frame.x), polygon.y[i] = dot(p, frame.y);
  }
  Choice chosen;
  if (room > 0) choose_largest(polygon, room, must, chosen);
  for (int i = 0; i < room; ++i) points.points[i] = points.points[chosen[i]];
  points.count = room;
}

/// Sees to it that the deepest point is there with the pair's own separation, and to the number of points.
int finish(const SignedDistance& distance, double tie, int max_points, Points& points) {
  const auto set = [&distance](const Vector3& p_A, ContactPoint& point) {
    point.p_A_W = p_A;
    point.p_B_W = p_A + distance.separation * distance.n;
    point.separation = distance.separation;
  };
  ContactPoint& deepest = points.points[points.deepest];
  if (points.count > 0 && deepest.separation - distance.separation <= tie) {
    set(deepest.p_A_W, deepest);
    if (points.count > max_points) reduce(distance.n, max_points, points.deepest, points);
    return points.count;
  }
  if (points.count >= max_points) reduce(distance.n, max_points - 1, -1, points);
  ContactPoint& witness = points.points[points.count++];
  set(distance.p_A, witness);
  witness.feature_id = kWitnessId;
  return points.count;
}

}  // namespace

void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_separation,
                   int max_points, Manifold& manifold) {
  const TangentFrame frame = tangent_frame(distance.n);
  const double extent = pair.hulls.extent, tie = kAsDeep * kRoundoff * extent;
  const double limit = std::max(max_separation, distance.separation);
  Facing a, b;
  find_facings(pair, frame.n, a, b);
  const auto faces = static_cast<std::uint32_t>(256 * a.face + 4096 * b.face);

  Outline<4> plain_a, plain_b;
  if (plain_outlines(pair, frame, a, b, plain_a, plain_b)) {
    Clip<4> common;
    clip(plain_a, plain_b, a, b, extent, common);
    Points points = write_corners(common, distance, limit, tie, faces, manifold.points.data());
    manifold.count = finish(distance, tie, max_points, points);
    return;
  }
  Outline<kMostCorners> outline_a, outline_b;
  Clip<kMostCorners> common;
  if (careful_outline(pair.a->faces[a.face], pair.hulls.a, extent, frame, 1.0, a, outline_a) &&
      careful_outline(pair.b->faces[b.face], pair.hulls.b, extent, frame, -1.0, b, outline_b))
    clip(outline_a, outline_b, a, b, extent, common);
  else
    common = {};
  std::array<ContactPoint, FlatPolygon::kMost + 1> corners;
  Points points = write_corners(common, distance, limit, tie, faces, corners.data());
  manifold.count = finish(distance, tie, max_points, points);
  std::copy(corners.begin(), corners.begin() + manifold.count, manifold.points.begin());
}

}  // namespace touchstone::native
