#include "touchstone/contact_core/fit/space/allowed_space.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace touchstone::fit {
namespace {

constexpr double kRoot3 = 1.7320508075688772;
constexpr double kLeaf = 1.0 / 12.0;   // half a leaf's width, of the limit
constexpr double kSlack = 1.0 / 32.0;  // a face stops so much of the limit before a point
constexpr double kFlat = 1e-3;         // of the limit: what a flat wall may bend
constexpr double kNever = kInfinity;
constexpr int kMostSteps = 16;         // of a search for a plane between a box and a hull
constexpr double kRounding = 0x1p-46;  // of coordinates: more than heights over such a plane are off

Vector3 octant(int i) {
  return {(i & 4) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 1) != 0 ? 1.0 : -1.0};
}

// A side of a cube, cut by half spaces: each adds a corner at most. Where rounding would add more they are
// left out.
class ClippedFace {
 public:
  void add(const Vector3& p) {
    if (count_ < corners_.size()) corners_[count_++] = p;
  }
  void clip(const Plane& plane) {
    const std::array<Vector3, 10> before = corners_;
    const std::size_t count = std::exchange(count_, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 &p = before[i], &q = before[(i + 1) % count];
      const double hp = plane.signed_distance(p), hq = plane.signed_distance(q);
      if (hp <= 0.0) add(p);
      if ((hp < 0.0 && hq > 0.0) || (hp > 0.0 && hq < 0.0)) add(p + (q - p) * (hp / (hp - hq)));
    }
  }
  std::span<const Vector3> corners() const { return std::span(corners_).first(count_); }

 private:
  std::array<Vector3, 10> corners_;
  std::size_t count_ = 0;
};

// The box that two boxes fill together, where they do: one holds the other, or they are alike but along an
// axis, and meet there.
std::optional<Bounds> filled_by(const Bounds& a, const Bounds& b) {
  const Bounds all{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
  for (const Bounds& each : {a, b})
    if (each.low == all.low && each.high == all.high) return all;
  int differ = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (a.low(axis) != b.low(axis) || a.high(axis) != b.high(axis)) ++differ;
  const bool meet = (a.low - b.high).maxCoeff() <= 0.0 && (b.low - a.high).maxCoeff() <= 0.0;
  return differ == 1 && meet ? std::optional(all) : std::nullopt;
}

// The box that all of them fill together, where they do; nothing where there are none.
std::optional<Bounds> as_one_box(std::vector<Bounds> boxes) {
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      if (i == j) continue;
      const std::optional<Bounds> both = filled_by(boxes[i], boxes[j]);
      if (!both) continue;
      boxes[std::min(i, j)] = *both;
      boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(std::max(i, j)));
      return as_one_box(std::move(boxes));
    }
  return boxes.size() == 1 ? std::optional(boxes.front()) : std::nullopt;
}

}  // namespace

bool LimitBox::touches(const Vector3& centre, double half) const {
  const Vector3 middle = rotate_back(axes, centre),
                reach = half * rotate_back(axes.cwiseAbs(), Vector3::Ones());
  return ((box.low - middle).array() <= reach.array()).all() &&
         ((middle - box.high).array() <= reach.array()).all();
}

bool LimitBox::touches(std::span<const Vector3> corners) const {
  // The box about the hull tells first.
  Bounds about;
  for (const Vector3& p : corners) about.add(rotate_back(axes, p));
  if ((box.low - about.high).maxCoeff() > 0.0 || (about.low - box.high).maxCoeff() > 0.0) return false;
  // A plane between the two is looked for, across the way from a point of the hull that comes nearer to the
  // box with each step (Frank and Wolfe's method).
  Vector3 p = Vector3::Zero();
  for (const Vector3& corner : corners) p += rotate_back(axes, corner) / static_cast<double>(corners.size());
  const double rounding = kRounding * std::max(norm_inf(about.low), norm_inf(about.high));
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector3 way = p - p.cwiseMax(box.low).cwiseMin(box.high);
    Vector3 next = p;
    double least = kInfinity;
    for (const Vector3& corner : corners) {
      const Vector3 at = rotate_back(axes, corner);
      if (const double height = dot(way, at); height < least) least = height, next = at;
    }
    if (least - dot(way, Vector3(p - way)) > rounding * norm(way)) return false;
    const Vector3 ahead = next - p;
    const double share = std::min(1.0, -dot(way, ahead) / dot(ahead, ahead));
    if (!(share > 0.0)) return true;
    p += share * ahead;
  }
  return true;
}

double least_limit(double over, std::span<const LimitBox> boxes, std::span<const Vector3> corners) {
  double least = over;
  for (const LimitBox& each : boxes)
    if (each.touches(corners)) least = std::min(least, each.limit);
  return least;
}

// The point that a growing face meets first: `best` is how far it goes until then.
struct AllowedSpace::Query {
  const SixPlanes& solid;
  int face;  // that grows; -1: none, any point within the solid is met at once
  Vector3 edge = Vector3::Zero(), across = Vector3::Zero();
  bool turns = false;
  double best = kNever;
  std::array<Vector3, 6> sizes{};  // of the planes' normals: how far they reach over half a box

  /// Bits of the faces that do not grow.
  unsigned others() const { return face < 0 ? 0x3fU : 0x3fU & ~(1U << face); }

  bool holds(const Vector3& p) const {
    for (int f = 0; f < 6; ++f)
      if (f != face && !(solid.planes[f].signed_distance(p) < 0.0)) return false;
    return true;
  }

  /// Whether the box is outside of one of these faces. Those that have all of it inside are taken out: none
  /// of them is asked of a box within it.
  bool is_beside(const Vector3& middle, const Vector3& size, unsigned& faces) const {
    for (int f = 0; f < 6; ++f) {
      if ((faces >> f & 1U) == 0) continue;
      const double height = solid.planes[f].signed_distance(middle), reach = dot(sizes[f], size);
      if (height >= reach) return true;
      if (height < -reach) faces &= ~(1U << f);
    }
    return false;
  }

  /// When the face meets the first point of a box, at the earliest.
  double earliest(const Vector3& middle, const Vector3& size) const {
    if (face < 0) return 0.0;
    return at_height(solid.planes[face].signed_distance(middle) - dot(sizes[face], size), middle, size);
  }

  /// The same of what is beyond a wall in a box, n p >= at. Any multiple of the wall taken off the height
  /// gives a bound; the best one makes an axis of what is left zero.
  double earliest(const Vector3& middle, const Vector3& size, const Vector3& wall, double at) const {
    if (face < 0) return 0.0;
    const Vector3& n = solid.planes[face].normal;
    const double base = solid.planes[face].signed_distance(middle), beyond = at - dot(wall, middle);
    double height = base - dot(sizes[face], size);
    // What is below only raises the height: a face that shifts meets nothing of the box before `best`.
    if (!turns && height >= best) return height;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(n(axis) * wall(axis) > 0.0)) continue;
      const double times = n(axis) / wall(axis);
      height = std::max(height, base + times * beyond - dot(Vector3((n - times * wall).cwiseAbs()), size));
    }
    return at_height(height, middle, size);
  }

  double at_height(double height, const Vector3& middle, const Vector3& size) const {
    if (!turns || height <= 0.0) return std::max(height, 0.0);
    const double out = dot(across, middle - edge) + dot(across.cwiseAbs(), size);
    return out > 0.0 ? height / out : kNever;
  }

  void meet(const Vector3& p, double limit) {
    if (holds(p)) meet_at(p, limit);
  }

  /// The same of a point that is known to be between the other faces.
  void meet_at(const Vector3& p, double limit) {
    double at = 0.0;
    if (face >= 0) {
      at = std::max(0.0, solid.planes[face].signed_distance(p) - kSlack * limit);
      if (turns) {
        const double out = dot(across, p - edge);
        at = out > 0.0 ? at / out : kNever;
      }
    }
    best = std::min(best, at);
  }
};

AllowedSpace::AllowedSpace(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes,
                           std::size_t most_cells)
    : mesh_(mesh), over_(over), boxes_(boxes.begin(), boxes.end()), most_cells_(most_cells) {
  const Bounds& all = mesh.bounds();
  const double half = 0.5 * (all.high - all.low).maxCoeff() + 1.01 * over;
  keep(make_cell(0.5 * (all.low + all.high), half, nullptr));
}

double AllowedSpace::limit_at(const Vector3& p) const { return least_limit(p, 0.0); }

double AllowedSpace::least_limit(const Vector3& centre, double half) const {
  double least = over_;
  for (const LimitBox& each : boxes_)
    if (each.touches(centre, half)) least = std::min(least, each.limit);
  return least;
}

double AllowedSpace::least_limit(std::span<const Vector3> corners) const {
  return fit::least_limit(over_, boxes_, corners);
}

bool AllowedSpace::holds_forbidden(const SixPlanes& solid) const {
  return std::any_of(forbidden_.begin(), forbidden_.end(),
                     [&](const Vector3& p) { return solid.above(p) <= 0.0; });
}

AllowedSpace::NewCell AllowedSpace::make_cell(const Vector3& centre, double half, const Place* parent) const {
  // A new cell spans its box and takes the least limit in it.
  NewCell cell;
  cell.centre = centre;
  cell.half = half;
  cell.low = centre - Vector3::Constant(half);
  cell.high = centre + Vector3::Constant(half);
  cell.least_limit = least_limit(centre, half);
  // The root asks the whole mesh; any other cell starts from what its parent knows.
  const MeshDistance::Nearest nearest =
      parent == nullptr ? mesh_.nearest(centre) : mesh_.nearest_from(centre, parent->triangle);
  cell.triangle = nearest.triangle;
  cell.winding = parent == nullptr ? mesh_.winding(centre) : winding_at(centre, *parent);
  cell.distance = cell.winding != 0 ? -nearest.distance : nearest.distance;
  classify(cell);
  if (cell.kind == Kind::open) draw_in(cell);
  return cell;
}

int AllowedSpace::winding_at(const Vector3& p, const Place& near) const {
  return mesh_.winding_near({near.centre, std::abs(near.distance), near.winding}, p);
}

void AllowedSpace::classify(NewCell& cell) const {
  const double reach = kRoot3 * cell.half;
  const double limit = limit_at(cell.centre);
  if (cell.distance + reach <= cell.least_limit) {
    cell.kind = Kind::clear;
  } else if (is_cut_by_boxes(cell)) {
    cell.kind = Kind::block;
  } else if (cell.distance - reach > over_ || (cell.least_limit == limit && cell.distance - reach > limit)) {
    cell.kind = Kind::block;
  } else {
    const Vector3 surface = mesh_.closest_on(cell.centre, cell.triangle);
    const Vector3 away = cell.centre - surface;
    if (cell.half > kLeaf * cell.least_limit) {
      if (is_near_one_triangle(cell, away)) cell.kind = Kind::clear;
    } else if (cell.distance <= limit) {
      cell.kind = Kind::clear;
    } else {
      cell.kind = Kind::point;  // towards the nearest point of the surface, where the limit is
      cell.low = cell.centre;
      if (cell.least_limit == limit) cell.low = surface + (limit / cell.distance) * away;
      cell.high = cell.low;
    }
  }
}

// Where boxes of smaller limits reach into the cell, which is beyond these limits everywhere and within the
// large one: then a block is what they share with the cell, where that is one box.
bool AllowedSpace::is_cut_by_boxes(NewCell& cell) const {
  const double reach = kRoot3 * cell.half;
  if (cell.distance + reach > over_) return false;
  std::vector<Bounds> shared;
  for (const LimitBox& each : boxes_) {
    if (!each.touches(cell.centre, cell.half)) continue;
    if (each.axes != Matrix3::Identity() || cell.distance - reach <= each.limit) return false;
    shared.push_back({cell.low.cwiseMax(each.box.low), cell.high.cwiseMin(each.box.high)});
  }
  const std::optional<Bounds> block = as_one_box(std::move(shared));
  if (!block) return false;
  cell.low = block->low;
  cell.high = block->high;
  return true;
}

// The distance to one triangle is convex: within the limit at the corners, within it everywhere.
bool AllowedSpace::is_near_one_triangle(const NewCell& cell, const Vector3& away) const {
  if (std::abs(cell.distance) > cell.least_limit) return false;
  int first = 0;
  for (int axis = 0; axis < 3; ++axis) first |= away(axis) > 0.0 ? 4 >> axis : 0;
  for (int i = 0; i < 8; ++i)  // the farthest corner first
    if (mesh_.to_triangle(cell.centre + cell.half * octant(first ^ i), cell.triangle) > cell.least_limit)
      return false;
  return true;
}

// A new cell's box leaves out what is allowed for sure, so that a search need not divide the cell to see it.
void AllowedSpace::draw_in(NewCell& cell) const {
  if (find_wall(cell)) return;
  const double limit = cell.least_limit;
  const auto is_near = [&](int axis, double at) {  // the cell's part in the plane across the axis
    for (int i = 0; i < 4; ++i) {
      Vector3 p;
      p(axis) = at;
      p((axis + 1) % 3) = (i & 1) != 0 ? cell.high((axis + 1) % 3) : cell.low((axis + 1) % 3);
      p((axis + 2) % 3) = (i & 2) != 0 ? cell.high((axis + 2) % 3) : cell.low((axis + 2) % 3);
      if (mesh_.to_triangle(p, cell.triangle) > limit) return false;
    }
    return true;
  };
  // The distance to one triangle is convex: what is between two planes that are near it is near it, too.
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool is_low : {true, false}) {
      double near = is_low ? cell.low(axis) : cell.high(axis),
             far = is_low ? cell.high(axis) : cell.low(axis);
      if (!is_near(axis, near)) continue;
      while (std::abs(far - near) > 0.5 * kSlack * limit) {
        const double middle = 0.5 * (near + far);
        (is_near(axis, middle) ? near : far) = middle;
      }
      (is_low ? cell.low : cell.high)(axis) = near;
    }
  }
}

// Where the surface in the cell, and from the cell to the nearest triangle, is one wall, what is not allowed
// begins a limit above it.
bool AllowedSpace::find_wall(NewCell& cell) const {
  const TriangleMesh& mesh = mesh_.mesh();
  const auto& corners = mesh.triangles[cell.triangle];
  const Vector3& foot = mesh.vertices[corners[0]];
  const Vector3 across = cross(mesh.vertices[corners[1]] - foot, mesh.vertices[corners[2]] - foot);
  if (norm(across) == 0.0) return false;
  const Vector3 n = across / norm(across);
  const Plane plane{n, -dot(n, foot)};
  // The box also holds where the cell's points are when they are moved on to the plane.
  Bounds box{cell.low, cell.high};
  Vector3 top = cell.centre, bottom = cell.centre;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = cell.centre + cell.half * octant(i);
    box.add(p - plane.signed_distance(p) * n);
    if (plane.signed_distance(p) > plane.signed_distance(top)) top = p;
    if (plane.signed_distance(p) < plane.signed_distance(bottom)) bottom = p;
  }
  const double limit = cell.least_limit;
  if (!mesh_.is_one_wall(box, plane, kFlat * limit)) return false;
  // Each side of the wall is outside or inside as a whole.
  const auto has_open = [&](const Vector3& farthest) {
    const double height = plane.signed_distance(farthest);
    return std::abs(height) > limit && winding_at(farthest - 0.5 * height * n, cell) == 0;
  };
  const bool is_open_above = plane.signed_distance(top) > 0.0 && has_open(top);
  const bool is_open_below = plane.signed_distance(bottom) < 0.0 && has_open(bottom);
  if (is_open_above && is_open_below) return false;
  if (!is_open_above && !is_open_below) {
    cell.kind = Kind::clear;
    return true;
  }
  cell.wall = is_open_above ? n : Vector3(-n);
  cell.wall_at = limit - kFlat * limit + (is_open_above ? -plane.offset : plane.offset);
  // The box is drawn in to what is beyond.
  const Vector3 farthest = (cell.wall.array() > 0.0).select(cell.high, cell.low);
  const double over = dot(cell.wall, farthest) - cell.wall_at;
  if (over <= kLeaf * limit) {  // leaves would not show it
    cell.kind = Kind::clear;
    return true;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (over < cell.wall(axis) * (cell.high(axis) - cell.low(axis)))
      cell.low(axis) = cell.high(axis) - over / cell.wall(axis);
    if (over < cell.wall(axis) * (cell.low(axis) - cell.high(axis)))
      cell.high(axis) = cell.low(axis) - over / cell.wall(axis);
  }
  return true;
}

void AllowedSpace::divide(std::uint32_t cell) {
  if (cells_.size() + 8 > most_cells_)
    reject("fit", "more than " + std::to_string(most_cells_) + " cells of space about a mesh of " +
                      figure(mesh_.bounds().diagonal()) + " m, at an error of " +
                      figure(least_limit(places_[0].centre, places_[0].half)) +
                      " m somewhere: ask for a larger one, or for it in smaller regions");
  const Place parent = places_[cell];
  const double half = 0.5 * parent.half;
  cells_[cell].children = static_cast<std::uint32_t>(cells_.size());
  for (int i = 0; i < 8; ++i) keep(make_cell(parent.centre + half * octant(i), half, &parent));
}

void AllowedSpace::keep(const NewCell& cell) {
  cells_.push_back(cell);
  places_.push_back(cell);
}

double AllowedSpace::earliest(const Query& query, const Cell& cell) {
  const Vector3 middle = 0.5 * (cell.low + cell.high), size = 0.5 * (cell.high - cell.low);
  if (cell.wall == Vector3::Zero()) return query.earliest(middle, size);
  return query.earliest(middle, size, cell.wall, cell.wall_at);
}

void AllowedSpace::search(Query& query) {
  for (int f = 0; f < 6; ++f) query.sizes[f] = query.solid.planes[f].normal.cwiseAbs();
  for (const Vector3& p : forbidden_) query.meet(p, limit_at(p));
  if (cells_[0].kind == Kind::clear || earliest(query, cells_[0]) >= query.best)
    ++visits_;
  else
    search(query, 0, query.others());
}

bool AllowedSpace::search(Query& query, std::uint32_t index, unsigned faces) {
  const Cell& cell = cells_[index];
  ++visits_;
  const Vector3 middle = 0.5 * (cell.low + cell.high), size = 0.5 * (cell.high - cell.low);
  if (query.is_beside(middle, size, faces)) return false;
  if (cell.kind == Kind::point) {
    query.meet(cell.low, cell.least_limit);
    return false;
  }
  if (cell.kind == Kind::block) {
    search_block(query, {cell.low, cell.high}, cell.least_limit, faces);
    return false;
  }
  const bool is_new = cell.children == 0;
  if (is_new) divide(index);
  return search_children(query, index, faces, is_new);
}

bool AllowedSpace::search_children(Query& query, std::uint32_t index, unsigned faces, bool is_new) {
  const std::uint32_t first = cells_[index].children;
  // Children that could improve the result are sorted by the best that they could give.
  std::array<std::pair<double, std::uint32_t>, 8> order;  // the earliest first
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Cell& child = cells_[first + i];
    if (child.kind == Kind::clear) continue;
    const double when = earliest(query, child);
    if (when >= query.best) continue;
    std::size_t at = count++;
    for (; at > 0 && order[at - 1].first > when; --at) order[at] = order[at - 1];
    order[at] = {when, first + i};
  }
  // They are searched in that order, as long as they could still improve it.
  bool has_learned = is_new;
  for (std::size_t i = 0; i < count && order[i].first < query.best; ++i)
    has_learned = search(query, order[i].second, faces) || has_learned;
  if (!has_learned) return false;
  // The cell's box shrinks to those of its children.
  Bounds left;  // what children learned
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Cell& child = cells_[first + i];
    if (child.kind == Kind::clear) continue;
    left.add(child.low);
    left.add(child.high);
  }
  Cell& cell = cells_[index];
  if (left.low.x() > left.high.x()) cell.kind = Kind::clear;
  cell.low = left.low;
  cell.high = left.high;
  return true;
}

// Nothing of a block is allowed. The face first meets a corner of what the block shares with the room between
// the other faces: one on the block's surface, or a corner of the solid within.
void AllowedSpace::search_block(Query& query, const Bounds& block, double limit, unsigned faces) const {
  const Vector3 centre = 0.5 * (block.low + block.high), size = 0.5 * (block.high - block.low);
  for (const auto& loop : Hexahedron::kFaceVertices) {
    ClippedFace face;
    for (const int corner : loop) face.add(centre + size.cwiseProduct(octant(corner)));
    for (int f = 0; f < 6; ++f)
      if ((faces >> f & 1U) != 0) face.clip(query.solid.planes[f]);
    for (const Vector3& p : face.corners()) query.meet_at(p, limit);
  }
  for (const Vector3& p : query.solid.corners())
    if (((p - centre).cwiseAbs().array() <= size.array()).all()) query.meet_at(p, limit);
}

// Mostly the cell that the point is in tells, or the triangle that is nearest to the cell's centre.
bool AllowedSpace::allows(const Vector3& p) const {
  const Place& place = places_[cell_at(p)];
  const double limit = limit_at(p), off = norm(p - place.centre) * (1.0 + 1e-9);
  if (place.distance + off <= limit || mesh_.to_triangle(p, place.triangle) <= limit) return true;
  if (place.distance - off > limit) return false;
  return mesh_.is_near(p, limit) || winding_at(p, place) != 0;
}

// The smallest one so far; of what is outside of all, the root.
std::uint32_t AllowedSpace::cell_at(const Vector3& p) const {
  std::uint32_t cell = 0;
  Vector3 centre = places_[0].centre;
  double half = places_[0].half;
  if ((p - centre).cwiseAbs().maxCoeff() > half) return cell;
  while (cells_[cell].children != 0) {
    int i = 0;
    for (int axis = 0; axis < 3; ++axis) i |= p(axis) > centre(axis) ? 4 >> axis : 0;
    half *= 0.5;
    centre += half * octant(i);
    cell = cells_[cell].children + static_cast<std::uint32_t>(i);
  }
  return cell;
}

bool AllowedSpace::allows_samples(const SixPlanes& solid) const {
  constexpr int kSteps = 6;
  if (!solid.is_hexahedron() || holds_forbidden(solid)) return false;
  const std::array<Vector3, 8> corners = solid.corners();
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const std::array<double, 3> at = {1.0 * i / kSteps, 1.0 * j / kSteps, 1.0 * k / kSteps};
        Vector3 p = Vector3::Zero();
        for (int c = 0; c < 8; ++c)
          p += ((c & 4) != 0 ? at[0] : 1.0 - at[0]) * ((c & 2) != 0 ? at[1] : 1.0 - at[1]) *
               ((c & 1) != 0 ? at[2] : 1.0 - at[2]) * corners[c];
        if (!allows(p)) return false;
      }
  return true;
}

bool AllowedSpace::allows(const SixPlanes& solid) {
  for (const Vector3& corner : solid.corners())
    if (!allows(corner)) return false;
  Query query{solid, -1};
  search(query);
  return query.best > 0.0;
}

double AllowedSpace::room(const SixPlanes& solid, int face, double far) {
  Query query{solid, face};
  query.best = far;
  search(query);
  return query.best;
}

double AllowedSpace::slope(const SixPlanes& solid, int face, const Vector3& edge, const Vector3& across,
                           double steepest) {
  Query query{solid, face, edge, across, true};
  query.best = steepest;
  search(query);
  return query.best;
}

}  // namespace touchstone::fit
