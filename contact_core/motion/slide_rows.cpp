#include "touchstone/contact_core/motion/slide_rows.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/clear_stretch.hpp"

namespace touchstone {
namespace {

/// A normal this close to a face's is the face's [rad], where the two are not so large that it leaves the
/// face by more than this share of the gap.
constexpr double kSameNormal = 1e-6;
constexpr double kSamePlane = 0.125;
/// A plane that a motion passes by less than this share of the gap lets it through: rounding of rows that
/// hold.
constexpr double kPassed = 1e-6;

struct FacePlane {
  bool exists = false;
  Vector3 n;  ///< from the obstacle to the mover
  bool turns = false;
};

FacePlane face_plane(const NearPair& pair, int plane) {
  FacePlane out;
  out.turns = plane < 6;
  const Vector3 n = out.turns ? Vector3(-rotate(pair.X_WM.R, pair.mover->face_plane(plane).normal))
                              : rotate(pair.X_WB.R, pair.obstacle->face_plane(plane - 6).normal);
  const double length = norm(n);
  out.exists = length > 0.5;  // else a collapsed face
  if (out.exists) out.n = n / length;
  return out;
}

double same_normal(const NearPair& pair) {
  const double size = pair.mover->bounding_sphere().radius + pair.obstacle->bounding_sphere().radius;
  return std::min(kSameNormal, kSamePlane * pair.gap / size);
}

/// The plane of the closest points turns with the mover where it is the plane of one of its faces and of
/// none of the obstacle's.
bool plane_turns(const NearPair& pair) {
  bool is_movers = false;
  for (int plane = 0; plane < 12; ++plane) {
    const FacePlane face = face_plane(pair, plane);
    if (!face.exists || !(norm(cross(face.n, pair.n)) < same_normal(pair)) || dot(face.n, pair.n) < 0.0)
      continue;
    if (plane >= 6) return false;
    is_movers = true;
  }
  return is_movers;
}

/// The vertices of a solid that are furthest along n, to `tolerance`: from one to the other of two; zero if
/// there are more or fewer.
Vector3 extreme_edge(const Hexahedron& solid, const WorldVertices& vertices, const Vector3& n,
                     double tolerance) {
  double highest = dot(n, vertices.vertex(0));
  for (int i = 1; i < Hexahedron::kVertices; ++i) highest = std::max(highest, dot(n, vertices.vertex(i)));
  const unsigned distinct = distinct_vertices(solid, vertices);
  int count = 0;
  std::array<int, Hexahedron::kVertices> extreme{};
  for (int i = 0; i < Hexahedron::kVertices; ++i)
    if ((distinct >> i & 1) && dot(n, vertices.vertex(i)) >= highest - tolerance) extreme[count++] = i;
  return count == 2 ? Vector3(vertices.vertex(extreme[1]) - vertices.vertex(extreme[0])) : Vector3::Zero();
}

struct PlacedPair {
  WorldVertices mover, obstacle;

  explicit PlacedPair(const NearPair& pair) {
    world_vertices(*pair.mover, pair.X_WM, mover);
    world_vertices(*pair.obstacle, pair.X_WB, obstacle);
  }
};

/// The edges that span the plane of the closest points.
void find_contact_edges(const PlacedPair& placed, NearPair& pair) {
  const double size = norm(pair.X_WM.p) + norm(pair.X_WB.p) + pair.mover->bounding_sphere().radius +
                      pair.obstacle->bounding_sphere().radius;
  const double tolerance = 4.0 * kSeparationRounding * size;
  const Vector3 e = extreme_edge(*pair.mover, placed.mover, -pair.n, tolerance);
  const Vector3 f = extreme_edge(*pair.obstacle, placed.obstacle, pair.n, tolerance);
  const double across = dot(pair.n, cross(e, f));
  if (std::abs(across) > 1e-3 * norm(e) * norm(f)) pair.e = e, pair.f = f / across;
}

/// How near the pair may come, and what lies between that and where find_impact stops it.
struct Keep {
  double separation, room;
};

Keep keep_of(double separation, double gap) {
  if (separation > gap) return {0.875 * gap, 0.125 * gap};
  if (separation >= 0.25 * gap) return {0.75 * gap, 0.25 * gap};
  return {separation, 0.0};
}

/// Of the cores. A solid that is rounded reaches its radius further, however it or the plane turns: rows at
/// the vertices, with the radii taken off the slack, hold for it to first order.
struct Heights {
  double highest_obstacle, lowest_mover;

  double apart() const { return lowest_mover - highest_obstacle; }
};

double radii_of(const NearPair& pair) { return pair.mover->radius() + pair.obstacle->radius(); }

Heights heights_along(const PlacedPair& placed, const Vector3& n) {
  Heights out{dot(n, placed.obstacle.vertex(0)), dot(n, placed.mover.vertex(0))};
  for (int i = 1; i < Hexahedron::kVertices; ++i) {
    out.highest_obstacle = std::max(out.highest_obstacle, dot(n, placed.obstacle.vertex(i)));
    out.lowest_mover = std::min(out.lowest_mover, dot(n, placed.mover.vertex(i)));
  }
  return out;
}

void find_planes_that_part(NearPair& pair) {
  const PlacedPair placed(pair);
  for (int plane = 0; plane < 12; ++plane) {
    const FacePlane face = face_plane(pair, plane);
    if (face.exists && heights_along(placed, face.n).apart() - radii_of(pair) >= 0.5 * pair.gap)
      pair.planes_that_part |= 1u << plane;
  }
  pair.are_planes_known = true;
}

using Rows = std::array<SlideRow, Hexahedron::kVertices>;

/// A face's plane keeps all vertices of the other solid on its far side.
int rows_of_face(const NearPair& pair, const FacePlane& face, Rows& rows) {
  const PlacedPair placed(pair);
  const Heights heights = heights_along(placed, face.n);
  const double radii = radii_of(pair);
  const Keep keep = keep_of(heights.apart() - radii, pair.gap);
  for (int i = 0; i < Hexahedron::kVertices; ++i) {
    const Vector3 p = face.turns ? placed.obstacle.vertex(i) : placed.mover.vertex(i);
    const double height = dot(face.n, p);
    const double over =
        (face.turns ? heights.lowest_mover - height : height - heights.highest_obstacle) - radii;
    rows[i] = {face.n,
               p - pair.centre_W,
               pair.share * (over - keep.separation),
               pair.share * keep.room,
               face.turns,
               Vector3::Zero(),
               Vector3::Zero(),
               pair.source,
               pair.link,
               pair.other_link};
  }
  return Hexahedron::kVertices;
}

int rows_of_points(const NearPair& pair, Rows& rows) {
  const Keep keep = keep_of(pair.separation, pair.gap);
  for (int i = 0; i < pair.point_count; ++i) {
    const ContactPoint& point = pair.points[i];
    rows[i] = {pair.n,
               (pair.turns ? point.p_A_W : point.p_B_W) - pair.centre_W,
               pair.share * (point.separation - keep.separation),
               pair.share * keep.room,
               pair.turns,
               pair.e,
               pair.f,
               pair.source,
               pair.link,
               pair.other_link};
  }
  return pair.point_count;
}

int rows_of_plane(const NearPair& pair, int plane, Rows& rows) {
  if (plane < 0) return rows_of_points(pair, rows);
  return (pair.planes_that_part >> plane & 1) != 0 ? rows_of_face(pair, face_plane(pair, plane), rows) : 0;
}

/// The share of a twist that the rows let through, to first order.
double share_let_through(const Rows& rows, int count, const Twist& twist, double gap) {
  double share = 1.0;
  for (int i = 0; i < count; ++i) {
    const double rate = dot(rows[i].n, twist.v + cross(twist.w, rows[i].r));
    const double slack = std::max(rows[i].slack, 0.0);
    if (slack + rate < -kPassed * gap) share = std::min(share, slack / -rate);
  }
  return share;
}

}  // namespace

void classify(NearPair& pair) {
  pair.is_sure = false;
  for (int plane = 0; plane < 12 && !pair.is_sure && pair.separation <= 2.0 * pair.gap; ++plane) {
    const FacePlane face = face_plane(pair, plane);
    pair.is_sure =
        face.exists && norm(cross(face.n, pair.n)) < same_normal(pair) && dot(face.n, pair.n) > 0.0;
  }
  pair.turns = plane_turns(pair);
  pair.e = pair.f = Vector3::Zero();
  pair.planes_that_part = 0, pair.are_planes_known = false;
  if (!pair.is_sure) find_contact_edges(PlacedPair(pair), pair);
}

bool choose_plane(NearPair& pair, const Twist& twist) {
  const int before = pair.plane;
  Rows rows;
  pair.plane = -1;
  double most = share_let_through(rows, rows_of_points(pair, rows), twist, pair.gap);
  if (most < 1.0 && !pair.are_planes_known) find_planes_that_part(pair);
  for (int plane = 0; plane < 12 && most < 1.0; ++plane) {
    const int count = rows_of_plane(pair, plane, rows);
    if (count == 0) continue;
    const double share = share_let_through(rows, count, twist, pair.gap);
    if (share > most) most = share, pair.plane = plane;
  }
  return pair.plane != before;
}

void add_rows(const NearPair& pair, double reach, std::vector<SlideRow>& rows) {
  Rows of_plane;
  const int count = rows_of_plane(pair, pair.plane, of_plane);
  for (int i = 0; i < count; ++i) {
    if (!(of_plane[i].slack < reach)) continue;
    // Where the list is full, the rows that would be left out in the end make room.
    if (rows.size() == rows.capacity()) order_rows(rows);
    rows.push_back(of_plane[i]);
  }
}

void order_rows(std::vector<SlideRow>& rows) {
  std::sort(rows.begin(), rows.end());
  if (rows.size() > kMostSlideRows) rows.resize(kMostSlideRows);
}

void collect_rows(std::span<const NearPair> near, bool all, std::vector<SlideRow>& rows) {
  rows.clear();
  for (const NearPair& pair : near)
    if (pair.is_sure || all) add_rows(pair, pair.reach, rows);
  order_rows(rows);
}

}  // namespace touchstone
