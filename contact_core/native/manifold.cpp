#include "contact_core/native/manifold.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/native/largest_choice.hpp"
#include "contact_core/native/outline_clip.hpp"
#include "contact_core/native/tangent_frame.hpp"

namespace touchstone::native {
namespace {

/// Points this close to the deepest are as deep: so many u * extent.
constexpr double kAsDeep = 64;
constexpr std::uint32_t kWitnessId = 0x10000;

template <int N>
struct Patch {
  Outline<N> a, b;
  Clip<N> clip;

  std::uint32_t label(int edge) const { return edge < N ? a.label[edge] : b.label[edge - N]; }
};

/// Contact points in the clip's order.
struct Points {
  ContactPoint* points;
  int count = 0;
  int deepest = 0;  ///< the first of those as deep as the deepest
};

/// Writes the clip's corners as contact points, those further apart than `limit` left out.
template <int N>
Points write_corners(const Patch<N>& patch, const SignedDistance& distance, double limit, double tie,
                     std::uint32_t faces, ContactPoint* points) {
  const Clip<N>& clip = patch.clip;
  const Vector3 n = distance.n;
  Points out{points};
  double least = limit;
  std::array<double, 2 * N> separations;
  std::uint32_t before = clip.count > 0 ? patch.label(clip.edge[clip.count - 1]) : 0;
  for (int k = 0; k < clip.count; ++k) {
    const int edge = clip.edge[k], i = edge % N;
    const bool on_a = edge < N;
    const Placed<N>& on = clip.on[on_a ? 0 : 1];
    const double s = on.separation[i];
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    const double separation = s > distance.separation ? s : distance.separation;
    ContactPoint& point = points[out.count];
    Vector3 &own = on_a ? point.p_A_W : point.p_B_W, &other = on_a ? point.p_B_W : point.p_A_W;
    const double across = on_a ? separation : -separation;
    const double x = on.p_x[i], y = on.p_y[i], z = on.p_z[i];
    own = {x, y, z};
    other = {x + across * n.x(), y + across * n.y(), z + across * n.z()};
    point.separation = separation;
    const std::uint32_t label = patch.label(edge);
    point.feature_id = (1 + before + 16 * label) + faces;
    before = label;
    separations[out.count] = separation;
    out.count += separation <= limit;
    least = separation < least ? separation : least;
  }
  for (int k = out.count - 1; k >= 0; --k) out.deepest = separations[k] <= least + tie ? k : out.deepest;
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

  Patch<4> plain;
  if (plain_outlines(pair, frame, a, b, plain.a, plain.b)) {
    clip(plain.a, plain.b, a, b, extent, plain.clip);
    Points points = write_corners(plain, distance, limit, tie, faces, manifold.points.data());
    manifold.count = finish(distance, tie, max_points, points);
    return;
  }
  Patch<kMostCorners> patch;
  if (careful_outline(pair.a->faces[a.face], pair.hulls.a, extent, frame, 1.0, a, patch.a) &&
      careful_outline(pair.b->faces[b.face], pair.hulls.b, extent, frame, -1.0, b, patch.b))
    clip(patch.a, patch.b, a, b, extent, patch.clip);
  std::array<ContactPoint, FlatPolygon::kMost + 1> corners;
  Points points = write_corners(patch, distance, limit, tie, faces, corners.data());
  manifold.count = finish(distance, tie, max_points, points);
  std::copy(corners.begin(), corners.begin() + manifold.count, manifold.points.begin());
}

}  // namespace touchstone::native
