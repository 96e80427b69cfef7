#include "touchstone/contact_core/fit/excess.hpp"

#include <algorithm>
#include <queue>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone {
namespace {

// A corner, with all that is known of it: pieces share them.
struct Corner {
  Vector3 p = Vector3::Zero();
  MeshDistance::Nearest nearest{0.0, 0};
  int winding = 0;
  bool is_known = false;

  bool is_inside() const { return winding != 0; }
};
using Corners = std::array<Corner, 4>;

struct Piece {
  Corners corners;
  double most;
  bool operator<(const Piece& other) const { return most < other.most; }
};

class ExcessSearch {
 public:
  /// @param limit where this alone is asked whether a point is farther [m]; else negative
  ExcessSearch(const MeshDistance& mesh, const Bounds* box, double resolution, double limit)
      : mesh_(mesh), box_(box), resolution_(resolution), limit_(limit) {}

  ExcessBound result{0.0, 0.0};
  std::priority_queue<Piece> open;

  void add(const std::array<Vector3, 4>& points) {
    Corners corners;
    for (int i = 0; i < 4; ++i) corners[i].p = points[i];
    add(corners, 0);
  }

  void add(Corners corners, std::uint32_t hint) {
    if (is_beside(corners)) return;
    ++result.pieces;
    // First bounds come from the triangles that are nearest to corners: most pieces end by one of these.
    double most = kInfinity;
    for (const Corner& corner : corners) {
      if (!corner.is_known) continue;
      most = std::min(most, farthest(corners, corner.nearest.triangle, most));
      if (is_enough(most)) return settle(most);
    }
    // The next one comes from the centre and radius of the piece.
    const Vector3 centre = 0.25 * ((corners[0].p + corners[1].p) + (corners[2].p + corners[3].p));
    double radius = 0.0;
    for (const Corner& corner : corners) radius = std::max(radius, norm(corner.p - centre));
    const MeshDistance::Nearest nearest = mesh_.nearest_from(centre, hint);
    most = std::min({most, farthest(corners, nearest.triangle, most), nearest.distance + radius});
    if (is_enough(most)) return settle(most);
    // A piece within the solid ends here.
    Corner middle{centre, nearest, 0, true};
    middle.winding = winding_near(middle, corners);
    if (middle.is_inside() && nearest.distance >= radius * (1.0 + 1e-12)) return;
    if (!middle.is_inside()) note(centre, nearest.distance);
    // Each corner tightens the bound by its nearest triangle and is held at a place in the solid: its own
    // where it is inside, else the nearest point of the surface.
    std::array<Vector3, 4> held{};
    double moved = 0.0;
    const Corner* deepest =
        &middle;  // or farthest out: the ball about it that no surface meets is the largest
    for (int i = 0; i < 4; ++i) {
      if (is_enough(most)) return settle(most);
      Corner& corner = corners[i];
      if (!corner.is_known) {
        corner.nearest = mesh_.nearest_from(corner.p, nearest.triangle);
        corner.winding = winding_near(corner, std::span(&middle, 1));
        corner.is_known = true;
        if (corner.nearest.triangle != nearest.triangle)
          most = std::min(most, farthest(corners, corner.nearest.triangle, most));
      }
      if (corner.nearest.distance > deepest->nearest.distance) deepest = &corner;
      held[i] = corner.p;
      if (corner.is_inside()) continue;
      note(corner.p, corner.nearest.distance);
      moved = std::max(moved, corner.nearest.distance);
      held[i] = mesh_.closest_on(corner.p, corner.nearest.triangle);
    }
    // If the tetrahedron of the held points is solid, no point is further out than its corners moved.
    const double slack = limit_ >= 0.0 ? limit_ - moved : 0.5 * resolution_;
    if (slack > 0.0 && moved + slack < most && is_solid(held, slack, corners, middle, *deepest))
      most = moved + slack;
    if (is_enough(most)) return settle(most);
    open.push({corners, most});
  }

  /// The largest bound of what was not looked at further.
  double settled() const { return settled_; }

  void divide(const Piece& piece) {
    int a = 0, b = 1;
    double longest = -1.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const double length = norm(piece.corners[i].p - piece.corners[j].p);
        if (length <= longest) continue;
        longest = length;
        a = i;
        b = j;
      }
    }
    Corner middle;
    middle.p = 0.5 * (piece.corners[a].p + piece.corners[b].p);
    middle.nearest = mesh_.nearest_from(middle.p, piece.corners[a].nearest.triangle);
    middle.winding = winding_near(middle, piece.corners);
    middle.is_known = true;
    for (const int corner : {a, b}) {
      Corners half = piece.corners;
      half[corner] = middle;
      add(half, middle.nearest.triangle);
    }
  }

 private:
  // A known corner has p's winding number where no surface is between both: p is nearer to it than the
  // surface is to either. Else the triangles that are between tell by how much the two numbers differ.
  int winding_near(const Corner& p, std::span<const Corner> corners) const {
    const Corner* farthest = nullptr;  // from the surface
    for (const Corner& known : corners) {
      if (!known.is_known) continue;
      if (std::max(p.nearest.distance, known.nearest.distance) > norm(known.p - p.p) * (1.0 + 1e-9))
        return known.winding;
      if (farthest == nullptr || known.nearest.distance > farthest->nearest.distance) farthest = &known;
    }
    if (farthest == nullptr) return mesh_.winding(p.p);
    return mesh_.winding_near({farthest->p, farthest->nearest.distance, farthest->winding}, p.p);
  }

  // Whether a piece of this bound need not be divided.
  bool is_enough(double most) const { return most <= std::max(limit_, result.least + resolution_); }

  void settle(double most) { settled_ = std::max(settled_, most); }

  void note(const Vector3& p, double distance) {
    if (distance <= result.least || !counts(p)) return;
    result.least = distance;
    result.where = p;
  }

  // Whether the tetrahedron, drawn in by the slack, is within the solid.
  bool is_solid(std::array<Vector3, 4> held, double slack, const Corners& corners, const Corner& middle,
                const Corner& near) const {
    const Vector3 centre = 0.25 * ((held[0] + held[1]) + (held[2] + held[3]));
    double radius = 0.0;
    for (const Vector3& p : held) radius = std::max(radius, norm(p - centre));
    const double share = std::min(0.5, slack / radius);
    for (Vector3& p : held) p += share * (centre - p);
    if (!(radius > 0.0) || is_clear(held, centre, middle)) return false;
    if (std::any_of(corners.begin(), corners.end(),
                    [&](const Corner& corner) { return is_clear(held, centre, corner); }))
      return false;
    return mesh_.is_solid(held, {near.p, near.nearest.distance, near.winding});
  }

  // Whether a corner of the tetrahedron, its centre, or the middle of an edge is in the ball about a point
  // outside that no surface meets: it then is outside, too.
  static bool is_clear(const std::array<Vector3, 4>& held, const Vector3& centre, const Corner& known) {
    if (known.is_inside()) return false;
    const double clear = known.nearest.distance * (1.0 - 1e-9), most = clear * clear;
    const auto has = [&](const Vector3& p) { return dot(p - known.p, p - known.p) < most; };
    if (has(centre)) return true;
    for (std::size_t i = 0; i < 4; ++i) {
      if (has(held[i])) return true;
      for (std::size_t j = i + 1; j < 4; ++j)
        if (has(0.5 * (held[i] + held[j]))) return true;
    }
    return false;
  }

  bool counts(const Vector3& p) const {
    return box_ == nullptr || ((p - box_->low).minCoeff() >= 0.0 && (box_->high - p).minCoeff() >= 0.0);
  }

  bool is_beside(const Corners& corners) const {
    if (box_ == nullptr) return false;
    Bounds bounds;
    for (const Corner& corner : corners) bounds.add(corner.p);
    return (bounds.high - box_->low).minCoeff() < 0.0 || (box_->high - bounds.low).minCoeff() < 0.0;
  }

  // Of the corners, from a triangle; or some distance of at least `most`.
  double farthest(const Corners& corners, std::uint32_t triangle, double most) const {
    double farthest = 0.0;
    for (std::size_t i = 0; i < corners.size() && farthest < most; ++i)
      farthest = std::max(farthest, mesh_.to_triangle(corners[i].p, triangle));
    return farthest;
  }

  const MeshDistance& mesh_;
  const Bounds* box_;
  double resolution_, limit_;
  double settled_ = 0.0;
};

// Fills the hull with pieces. @return what distances, midpoints and bends are off by: a few roundings of the
// largest coordinate
double fill(ExcessSearch& search, const MeshDistance& mesh, const std::array<Vector3, 8>& vertices) {
  // All pieces have the centre of the vertices as a corner.
  Vector3 centre = Vector3::Zero();
  double largest = mesh.largest_coordinate();
  for (const Vector3& p : vertices) {
    centre += 0.125 * p;
    largest = std::max(largest, norm_inf(p));
  }
  // Each face is folded along both diagonals: together the pieces fill the hull, however its faces bend.
  for (const auto& face : Hexahedron::kFaceVertices) {
    for (int fold = 0; fold < 2; ++fold) {
      const Vector3 &a = vertices[face[fold]], &b = vertices[face[fold + 1]], &c = vertices[face[fold + 2]],
                    &d = vertices[face[(fold + 3) % 4]];
      // One fold is enough for a face that is flat to rounding; what the other adds is in the margin.
      const Vector3 n = cross(c - a, d - b);
      const double bend = norm(n) > 0.0 ? std::abs(dot(n, b - a)) / norm(n) : 0.0;
      if (fold == 1 && bend <= 0x1p-44 * largest) continue;
      search.add({centre, a, b, c});
      search.add({centre, a, c, d});
    }
  }
  return 0x1p-42 * largest;
}

// The worst piece is divided until the bound is close enough, or decides.
void divide_worst(ExcessSearch& search, double resolution, double enough, std::size_t most_pieces,
                  double known = kInfinity) {
  constexpr std::size_t kFewPieces = 500;  // that may bound it closer than what is known
  while (!search.open.empty() && search.result.pieces < most_pieces) {
    const double most = search.open.top().most;
    if (most <= search.result.least + resolution || most <= enough) break;
    if (known <= search.result.least + resolution && search.result.pieces >= kFewPieces) break;
    if (enough > 0.0 && search.result.least > enough) break;
    const Piece piece = search.open.top();
    search.open.pop();
    search.divide(piece);
  }
  const double open = search.open.empty() ? 0.0 : search.open.top().most;
  search.result.most = std::max({open, search.settled(), search.result.least});
}

}  // namespace

ExcessBound bound_excess(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices, double resolution,
                         double enough, const Bounds* box, std::size_t most_pieces, double known) {
  ExcessSearch search(mesh, box, resolution, -1.0);
  const double rounding = fill(search, mesh, vertices);
  divide_worst(search, resolution, enough, most_pieces, known);
  search.result.most = std::min(search.result.most + rounding, known);
  return search.result;
}

ExcessBound judge_excess(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices, double limit,
                         double resolution, const Bounds* box, std::size_t most_pieces) {
  ExcessBound bound = bound_excess(mesh, vertices, resolution, limit, box, most_pieces);
  const bool is_open = bound.least <= limit && bound.most > limit;
  if (is_open && !find_beyond(mesh, vertices, limit, resolution, box, most_pieces)) bound.most = limit;
  return bound;
}

std::optional<Vector3> find_beyond(const MeshDistance& mesh, const std::array<Vector3, 8>& vertices,
                                   double limit, double resolution, const Bounds* box,
                                   std::size_t most_pieces, std::uint64_t* looked_at) {
  double largest = mesh.largest_coordinate();
  for (const Vector3& p : vertices) largest = std::max(largest, norm_inf(p));
  const double below = std::max(0.0, limit - 0x1p-41 * largest);  // the bound's rounding is added below it
  ExcessSearch search(mesh, box, resolution, below);
  search.result.where = vertices[0];
  const double rounding = fill(search, mesh, vertices);
  divide_worst(search, resolution, below, most_pieces);
  if (looked_at != nullptr) *looked_at += search.result.pieces;
  if (search.result.most + rounding <= limit) return std::nullopt;
  return search.result.where;
}

}  // namespace touchstone
