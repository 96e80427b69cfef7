#include "touchstone/adapters/cover_proof/excess_proof.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace touchstone::cover_proof {
namespace {

bool is_in(const CoverClaim::Region* region, const Vector3& p) {
  return region == nullptr || ((p - region->low).minCoeff() >= 0.0 && (region->high - p).minCoeff() >= 0.0);
}

}  // namespace

bool ExcessProof::is_within_one(const Tetrahedron& piece, std::uint32_t triangle) const {
  const double most = limit_ - margin_;
  if (!(most >= 0.0)) return false;
  return std::all_of(piece.begin(), piece.end(),
                     [&](const Vector3& p) { return surface_.squared_distance(p, triangle) <= most * most; });
}

namespace {

// A triangle that half spaces cut: each adds a corner at most.
class CutTriangle {
 public:
  CutTriangle(const Vector3& a, const Vector3& b, const Vector3& c) : corners_{a, b, c} {}
  bool is_empty() const { return count_ == 0; }
  /// Leaves what is at most `most` above the plane, or all where rounding makes many corners of it.
  void cut(const Vector3& n, const Vector3& foot, double most) {
    const std::array<Vector3, kMost> before = corners_;
    const std::size_t count = std::exchange(count_, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 &p = before[i], &q = before[(i + 1) % count];
      const double hp = dot(n, p - foot) - most, hq = dot(n, q - foot) - most;
      if (count_ + 2 > kMost) {
        corners_ = before;
        count_ = count;
        return;
      }
      if (hp <= 0.0) corners_[count_++] = p;
      if ((hp < 0.0 && hq > 0.0) || (hp > 0.0 && hq < 0.0))
        corners_[count_++] = p + (q - p) * (hp / (hp - hq));
    }
  }

 private:
  // 3, and one for each of the box's 6 planes and the 4 of the tetrahedron: 13. Rounding may have a plane
  // cross the outline more than twice, as a sliver's: room for some such corners.
  static constexpr std::size_t kMost = 20;
  std::array<Vector3, kMost> corners_;
  std::size_t count_ = 3;
};

}  // namespace

// Triangles that may meet the tetrahedron; nothing where they are many. Of the others, cut by its box,
// `margin_` wider, and by its four planes, wider by what rounding can turn their normals over the size of the
// box too, nothing is left. A plane that rounding turns as it likes cuts nothing.
std::optional<std::vector<std::uint32_t>> ExcessProof::met_by(const Tetrahedron& piece) const {
  constexpr std::size_t kMostMet = 24;
  // Only triangles within the margin of the piece's box can be too near.
  Vector3 low = piece[0], high = piece[0];
  for (const Vector3& p : piece) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector3 wider = Vector3::Constant(margin_);
  const double size = norm(high - low);
  std::vector<std::uint32_t> met;
  surface_.meeting(low - wider, high + wider, [&](std::uint32_t t) {
    if (met.size() > kMostMet) return;
    const Vector3 u = surface_.corner(t, 0), v = surface_.corner(t, 1), w = surface_.corner(t, 2);
    if ((u.cwiseMin(v).cwiseMin(w) - high).maxCoeff() > margin_) return;
    if ((low - u.cwiseMax(v).cwiseMax(w)).maxCoeff() > margin_) return;
    // The box clips first: planes of a thin piece may be too inaccurate to do so.
    CutTriangle rest(u, v, w);
    for (int axis = 0; axis < 3 && !rest.is_empty(); ++axis) {
      rest.cut(Vector3::Unit(axis), high, margin_);
      rest.cut(-Vector3::Unit(axis), low, margin_);
    }
    // Planes of the piece clip next, moved outwards by the margin and by what rounding may do.
    for (int apex = 0; apex < 4 && !rest.is_empty(); ++apex) {
      const Vector3 &a = piece[(apex + 1) % 4], &b = piece[(apex + 2) % 4], &c = piece[(apex + 3) % 4];
      Vector3 n = cross(b - a, c - a);
      const double length = norm(n);
      const double off = 0x1p-48 * norm(b - a) * norm(c - a) * size / length;
      if (!(off < size)) continue;  // a length of 0, too
      n /= dot(n, piece[apex] - a) > 0.0 ? -length : length;
      rest.cut(n, a, margin_ + off);
    }
    if (!rest.is_empty()) met.push_back(t);
  });
  if (met.size() > kMostMet) return std::nullopt;
  return met;
}

// Groups of triangles that do not surely show a point their front, and of which a straight way from it passes
// one at most from back to front. Of two in turn: after the first it is in front of that one's plane, and
// before the second behind the other's; not so where all of the second is behind the first, or all of the
// first in front of the second. Of two at once: they lie in one plane, face alike and overlap there, as flush
// walls of two shells do. (Other ways that pass two at once go through a line: each point of theirs has
// others beside it to which the way does not.)
std::size_t ExcessProof::groups_of_backs(const Vector3& from, const std::vector<std::uint32_t>& met) const {
  const auto excludes = [&](std::uint32_t first, std::uint32_t second) {
    return solid_.is_all_on(first, second, -1) || solid_.is_all_on(second, first, 1);
  };
  std::vector<std::vector<std::uint32_t>> groups;
  for (const std::uint32_t t : met) {
    if (solid_.is_before(t, from)) continue;
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& others) {
      return std::all_of(others.begin(), others.end(), [&](std::uint32_t other) {
        return excludes(t, other) && excludes(other, t) && !solid_.may_be_passed_at_once(t, other);
      });
    });
    if (group != groups.end())
      group->push_back(t);
    else
      groups.push_back({t});
  }
  return groups.size();
}

// Whether the closed shells wind about all of the tetrahedron. On a straight way from one point of it to
// another the winding number falls by one at each triangle that it passes from back to front, and nowhere
// else. So it is positive everywhere where at one point it is larger than the groups that the way may meet.
bool ExcessProof::is_solid(const Tetrahedron& piece) const {
  const std::optional<std::vector<std::uint32_t>> met = met_by(piece);
  if (!met) return false;
  const Vector3 middle = 0.25 * (piece[0] + piece[1] + piece[2] + piece[3]);
  if (met->empty()) {
    std::uint32_t triangle = 0;
    const double clearance = std::sqrt(surface_.nearest(middle, triangle)) - surface_.blur() - margin_;
    return clearance > 0.0 && solid_.is_inside(middle, clearance);
  }
  for (const Vector3& from : {middle, piece[0], piece[1], piece[2], piece[3]}) {
    const std::optional<int> winding = solid_.winding_about(from);
    if (winding && *winding > 0 && static_cast<std::size_t>(*winding) > groups_of_backs(from, *met))
      return true;
  }
  return false;
}

// Each corner outside has a point of the surface near it. If the tetrahedron of these and of the corners
// inside is within the solid, a point of the piece is at most as far from it as the farthest corner is: mixed
// alike, they give a point for every point. It is drawn in by what the limit leaves, off the surface.
bool ExcessProof::is_within_solid(Piece& piece) const {
  Tetrahedron held = piece.points();
  double moved = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    Corner& corner = piece.corners[i];
    const double clearance = corner.distance - surface_.blur() - margin_;
    if (!corner.is_inside) corner.is_inside = clearance > 0.0 && solid_.is_inside(corner.p, clearance);
    if (*corner.is_inside) continue;
    moved = std::max(moved, corner.distance);
    held[i] = surface_.closest(corner.p, corner.triangle);
  }
  const double slack = limit_ - moved - 2.0 * margin_;
  if (!(slack > 0.0)) return false;
  const Vector3 middle = 0.25 * (held[0] + held[1] + held[2] + held[3]);
  double radius = 0.0;
  for (const Vector3& p : held) radius = std::max(radius, norm(p - middle));
  const double share = std::min(0.5, slack / std::max(radius, 1e-300));
  for (Vector3& p : held) p += share * (middle - p);
  return is_solid(held);
}

bool ExcessProof::is_beside(const Tetrahedron& piece) const {
  if (region_ == nullptr) return false;
  Vector3 low = piece[0], high = piece[0];
  for (const Vector3& p : piece) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - region_->low).minCoeff() < 0.0 || (region_->high - low).minCoeff() < 0.0;
}

bool ExcessProof::is_beyond(const Corner& corner) {
  const double distance = is_in(region_, corner.p) ? corner.distance - surface_.blur() : 0.0;
  if (distance <= limit_ || solid_.is_inside(corner.p, distance)) return false;
  beyond_ = corner.p;
  return true;
}

void ExcessProof::find_nearest(Corner& corner, std::uint32_t hint) const {
  if (corner.distance >= 0.0) return;
  corner.triangle = hint;
  corner.distance = std::sqrt(surface_.nearest(corner.p, corner.triangle));
}

ExcessProof::Finding ExcessProof::look_at(Piece& now) {
  ++pieces_;
  const Tetrahedron piece = now.points();
  std::uint32_t& hint = now.hint;
  if (is_beside(piece) || is_within_one(piece, hint)) return Finding::within;
  const Vector3 middle = 0.25 * (piece[0] + piece[1] + piece[2] + piece[3]);
  double radius = 0.0;
  for (const Vector3& p : piece) radius = std::max(radius, norm(p - middle));
  const double distance = std::sqrt(surface_.nearest(middle, hint));
  if (is_within_one(piece, hint) || distance + radius <= limit_ - margin_) return Finding::within;
  // No triangle reaches the ball about it: all of it is on one side.
  const double at_least = distance - surface_.blur();
  if (at_least > radius + margin_) {
    if (solid_.is_inside(middle, at_least)) return Finding::within;
    if (at_least > limit_ && is_in(region_, middle)) {
      beyond_ = middle;
      return Finding::beyond;
    }
    return Finding::open;
  }
  for (Corner& corner : now.corners) {
    find_nearest(corner, hint);
    if (corner.triangle != hint && is_within_one(piece, corner.triangle)) return Finding::within;
  }
  if (is_within_solid(now)) return Finding::within;
  return std::any_of(now.corners.begin(), now.corners.end(),
                     [&](const Corner& corner) { return is_beyond(corner); })
             ? Finding::beyond
             : Finding::open;
}

std::string ExcessProof::prove(const Hull& hull, const std::array<Vector3, 8>& vertices, double limit,
                               const CoverClaim::Region* region) {
  // Limit and region hold for all pieces of this hexahedron.
  limit_ = limit;
  region_ = region;
  const std::size_t stop = pieces_ + most_pieces_;
  Vector3 middle = Vector3::Zero();
  for (const Vector3& p : vertices) middle += 0.125 * p;
  std::vector<Piece> open;  // fans over the facets, from a point within
  for (const FacetPlane& facet : hull.planes)
    for (std::size_t i = 2; i < facet.corners.size(); ++i)
      open.push_back({{Corner{middle}, Corner{vertices[facet.corners[0]]},
                       Corner{vertices[facet.corners[i - 1]]}, Corner{vertices[facet.corners[i]]}},
                      0});
  // Branch and bound: a piece is within the limit, beyond it, or split.
  while (!open.empty()) {
    Piece now = open.back();
    open.pop_back();
    const Finding finding = look_at(now);
    if (finding == Finding::beyond) return "is farther than claimed at " + text_of(beyond_) + " m";
    if (finding == Finding::within) continue;
    if (pieces_ > stop) return "takes too many pieces to bound, about " + text_of(now.corners[0].p) + " m";
    // The longest edge is halved, so that pieces do not become slivers.
    std::size_t a = 0, b = 1;
    const Tetrahedron piece = now.points();
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (norm(piece[i] - piece[j]) > norm(piece[a] - piece[b])) {
          a = i;
          b = j;
        }
    Corner half{0.5 * (piece[a] + piece[b])};
    find_nearest(half, now.hint);
    Piece other = now;
    now.corners[a] = half;
    other.corners[b] = half;
    open.push_back(now);
    open.push_back(other);
  }
  return "";
}

}  // namespace touchstone::cover_proof
