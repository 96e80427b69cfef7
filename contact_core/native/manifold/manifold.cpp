#include "touchstone/contact_core/native/manifold/manifold.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/common/tangent_frame.hpp"
#include "touchstone/contact_core/native/manifold/point_reduction.hpp"
#include "touchstone/contact_core/native/manifold/polygon_clip.hpp"

namespace touchstone::native {
namespace {

constexpr std::uint32_t kWitnessId = 0x10000;

/// Contact points in the clip's order.
struct Points {
  ContactPoint* points;
  int count = 0;
  int deepest = 0;  ///< the first of those as deep as the deepest
};

/// The corners of a kernel's clip: as Clip<4>.
struct CornersOfLanes {
  explicit CornersOfLanes(const HullClipRecord& from)
      : p_x(from.p_x), p_y(from.p_y), p_z(from.p_z), separation(from.separation) {
    const auto bits_at = [&from](int first, unsigned mask) {
      return static_cast<unsigned>(from.bits >> first) & mask;
    };
    std::array<unsigned, 4> behind;
    for (int j = 0; j < 4; ++j) behind[j] = bits_at(HullClipBits::kBehind + 4 * j, 0xfu);
    order =
        order_edges<4>(4, behind, bits_at(HullClipBits::kLeft, 0xfu), bits_at(HullClipBits::kLeft + 4, 0xfu));
  }

  Order<4> order;
  const double *p_x, *p_y, *p_z, *separation;
  std::array<std::uint8_t, 8> label;
};

/// The labels of two quadrangles' edges, A's first; and where points are those of (b, a).
constexpr std::array<std::array<std::uint8_t, 8>, 2> kLabels = [] {
  std::array<std::array<std::uint8_t, 8>, 2> out{};
  for (int k = 0; k < 8; ++k)
    for (const bool swapped : {false, true}) out[swapped][k] = edge_label(k % 4, 4, k >= 4, swapped);
  return out;
}();

/// Writes the clip's corners as contact points, those further apart than `limit` left out.
template <int N, class Corners>
Points write_corners(const Corners& clip, const SignedDistance& distance, double limit, double tie,
                     std::uint32_t faces, bool swapped, ContactPoint* points) {
  const Vector3 n = distance.n;
  const std::uint32_t first = swapped ? 16 : 1, second = swapped ? 1 : 16;
  Points out{points};
  // Which corners stay, without a branch that no predictor can guess.
  std::array<double, 2 * N> separations;
  std::array<std::uint8_t, 2 * N> edges;
  double least = limit;
  std::uint32_t before = clip.label[last_corner(clip.order)];
  visit_corners(clip.order, [&](int edge) {
    // No pair of points lies deeper than the pair; what rounding puts below is as deep.
    const double s = clip.separation[edge], separation = s > distance.separation ? s : distance.separation;
    const std::uint32_t label = clip.label[edge];
    separations[out.count] = separation, edges[out.count] = static_cast<std::uint8_t>(edge);
    points[out.count].feature_id = (1 + first * before + second * label) + faces;
    const bool keep = (separation <= limit) & (label != before);
    least = keep && separation < least ? separation : least;
    out.count += keep ? 1 : 0;
    before = label;
  });
  // Their points.
  unsigned deep = 0;
  for (int k = 0; k < out.count; ++k) {
    const double separation = separations[k], on_b = edges[k] < N ? 0.0 : 1.0;
    const double to_a = -on_b * separation, to_b = (1.0 - on_b) * separation;
    const double x = clip.p_x[edges[k]], y = clip.p_y[edges[k]], z = clip.p_z[edges[k]];
    ContactPoint& point = points[k];
    point.p_A_W = {x + to_a * n.x(), y + to_a * n.y(), z + to_a * n.z()};
    point.p_B_W = {x + to_b * n.x(), y + to_b * n.y(), z + to_b * n.z()};
    point.separation = separation;
    deep |= (separation <= least + tie ? 1u : 0u) << k;
  }
  out.deepest = out.count > 0 ? std::countr_zero(deep) : 0;
  return out;
}

/// The face's index in Hexahedron::kFaceVertices where all six are plane, else the hull's index.
int face_name(const SolidFeatures& solid, int face) {
  if (solid.face_count != 6) return face;
  const auto& quads = Hexahedron::kFaceVertices;
  const auto& loop = solid.faces[face].vertices;
  const auto same = [&loop](const auto& quad) { return quad[0] == loop[0] && quad[1] == loop[1]; };
  const auto* const found = std::find_if(quads.begin(), quads.end(), same);
  return found == quads.end() ? face : static_cast<int>(found - quads.begin());
}

/// The point on A: the second where points are those of (b, a).
const Vector3& on_a(const ContactPoint& point, bool swapped) {
  return *std::array{&point.p_A_W, &point.p_B_W}[swapped];
}

/// Keeps `room` of the points, `must` among them unless it is negative.
void reduce(const Vector3& n, bool swapped, int room, int must, Points& points) {
  const TangentFrame frame = tangent_frame(n);
  FlatPolygon polygon;
  polygon.count = points.count;
  for (int i = 0; i < points.count; ++i) {
    const Vector3& p = on_a(points.points[i], swapped);
    polygon.x[i] = dot(p, frame.x), polygon.y[i] = dot(p, frame.y);
  }
  Choice chosen;
  if (room > 0) choose_largest_polygon(polygon, room, must, chosen);
  for (int i = 0; i < room; ++i) points.points[i] = points.points[chosen[i]];
  points.count = room;
}

/// Ensures that the deepest point is there with the pair's separation, and limits the number of points.
/// @param has_deepest whether points.deepest is as deep as the pair.
int finish(const SignedDistance& distance, bool swapped, bool has_deepest, int max_points, Points& points) {
  const auto set = [&distance, swapped](const Vector3& p_A, ContactPoint& point) {
    const std::array<Vector3, 2> p = {p_A, p_A + distance.separation * distance.n};
    point.p_A_W = p[swapped];
    point.p_B_W = p[!swapped];
    point.separation = distance.separation;
  };
  if (has_deepest) {
    ContactPoint& deepest = points.points[points.deepest];
    set(on_a(deepest, swapped), deepest);
    if (points.count > max_points) reduce(distance.n, swapped, max_points, points.deepest, points);
    return points.count;
  }
  if (points.count >= max_points) reduce(distance.n, swapped, max_points - 1, -1, points);
  ContactPoint& witness = points.points[points.count++];
  set(distance.p_A, witness);
  witness.feature_id = kWitnessId;
  return points.count;
}

int finish(const SignedDistance& distance, double tie, int max_points, Points& points) {
  const bool has_deepest =
      points.count > 0 && points.points[points.deepest].separation - distance.separation <= tie;
  return finish(distance, false, has_deepest, max_points, points);
}

}  // namespace

int finish_clip(const SignedDistance& distance_W, bool swapped, const ClipRecord& clipped, int max_points,
                ContactPoint* points) {
  Points of_clip{points, clipped.count, clipped.deepest};
  return finish(distance_W, swapped, clipped.deepest >= 0, max_points, of_clip);
}

void finish_hull_clip(const HullClipRecord& clipped, const SignedDistance& distance,
                      double max_point_separation, int max_points, bool swapped, Manifold& manifold) {
  const double tie = clipped.tie, limit = std::max(distance.separation + tie, max_point_separation);
  Points points{manifold.points.data()};
  // Most pairs that are apart have no corner within the limit.
  if ((clipped.bits >> HullClipBits::kNear & 0xffu) != 0) {
    CornersOfLanes corners(clipped);
    corners.label = kLabels[swapped];
    for (std::uint64_t rest = clipped.flush; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest) % 4, j = 4 + std::countr_zero(rest) / 4;
      corners.label[swapped ? i : j] = corners.label[swapped ? j : i];
    }
    const auto face_a = static_cast<std::uint32_t>(clipped.bits >> HullClipBits::kFaceA & 0xfu);
    const auto face_b = static_cast<std::uint32_t>(clipped.bits >> HullClipBits::kFaceB & 0xfu);
    const std::uint32_t faces = 256 * (swapped ? face_b : face_a) + 4096 * (swapped ? face_a : face_b);
    points = write_corners<4>(corners, distance, limit, tie, faces, swapped, manifold.points.data());
  }
  manifold.count = finish(distance, tie, max_points, points);
}

void make_manifold(const PosedPair& pair, const SignedDistance& distance, double max_point_separation,
                   int max_points, bool swapped, Manifold& manifold) {
  const TangentFrame frame = tangent_frame(distance.n);
  const double extent = pair.hulls.extent, tie = hull_clip::kAsDeep * kRoundoff * extent;
  const double limit = std::max(distance.separation + tie, max_point_separation);  // of NaN: the first
  // The faces that look most along the normal are those in contact.
  ContactFace a, b;
  find_contact_faces(pair, frame.n, a, b);
  a.swapped = b.swapped = swapped;
  // Points are known again by their faces, whose names are the same in either order.
  const int name_a = face_name(*pair.a, a.face), name_b = face_name(*pair.b, b.face);
  const auto faces =
      static_cast<std::uint32_t>(256 * (swapped ? name_b : name_a) + 4096 * (swapped ? name_a : name_b));

  // Two plain quadrangles share at most eight corners, which the manifold holds without a copy.
  FacePolygon<4> plain_a, plain_b;
  if (plain_polygons(pair, frame, a, b, plain_a, plain_b)) {
    Clip<4> common;
    clip(plain_a, plain_b, a, b, extent, common);
    Points points = write_corners<4>(common, distance, limit, tie, faces, swapped, manifold.points.data());
    manifold.count = finish(distance, tie, max_points, points);
    return;
  }
  // Other faces may share more corners than the manifold holds, so these are chosen from a copy.
  FacePolygon<kMostCorners> polygon_a, polygon_b;
  Clip<kMostCorners> common;
  if (general_polygon(*pair.a, pair.hulls.a, extent, frame, 1.0, a, polygon_a) &&
      general_polygon(*pair.b, pair.hulls.b, extent, frame, -1.0, b, polygon_b))
    clip(polygon_a, polygon_b, a, b, extent, common);
  else
    common = {};
  std::array<ContactPoint, FlatPolygon::kMost + 1> corners;
  Points points = write_corners<kMostCorners>(common, distance, limit, tie, faces, swapped, corners.data());
  manifold.count = finish(distance, tie, max_points, points);
  std::copy(corners.begin(), corners.begin() + manifold.count, manifold.points.begin());
}

}  // namespace touchstone::native
