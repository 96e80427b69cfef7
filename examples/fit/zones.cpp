#include "touchstone/examples/fit/zones.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone::fitting {
namespace {

constexpr int kCells = 48;  // along the longest side of the room about a mesh
constexpr std::size_t kMostZones = 8;
constexpr double kLeastGain = 0.125;  // of a zone's cells of the mesh: what dividing it saves at least
constexpr double kFinest =
    1.0 / 16;  // of the margin: a piece so small beside all zones is not looked at closer

bool is_empty(const Bounds& box) { return (box.high - box.low).minCoeff() < 0.0; }

Bounds both(const Bounds& a, const Bounds& b) { return {a.low.cwiseMax(b.low), a.high.cwiseMin(b.high)}; }

bool holds(const Bounds& outer, const Bounds& inner) {
  return (inner.low - outer.low).minCoeff() >= 0.0 && (outer.high - inner.high).minCoeff() >= 0.0;
}

// A box that is turned, and grown all around.
struct TurnedBox {
  Matrix3 R_OT, size_of;  // the second: absolute values of the first
  Vector3 p_T, middle_O, half_O;

  TurnedBox(const Bounds& part_O, const Pose& X_TO, double by)
      : R_OT(X_TO.R.transpose()),
        size_of(R_OT.cwiseAbs()),
        p_T(X_TO.p),
        middle_O(0.5 * (part_O.low + part_O.high)),
        half_O(0.5 * (part_O.high - part_O.low) + Vector3::Constant(by)) {}

  Bounds bounds() const {
    const Vector3 middle = rotate_back(R_OT, middle_O) + p_T, half = rotate_back(size_of, half_O);
    return {middle - half, middle + half};
  }
  // As far as the axes of both tell, up to those across an edge of each.
  bool meets(const Vector3& middle, const Vector3& half) const {
    const Vector3 off = rotate(R_OT, Vector3(middle - p_T)) - middle_O;
    return ((off.cwiseAbs() - rotate(size_of, half)).array() <= half_O.array()).all();
  }
};

// Whether every piece of the box that meets the other one is in a zone.
bool is_held(const Bounds& box, const TurnedBox& other, std::span<const Bounds> zones, double smallest) {
  if (!other.meets(0.5 * (box.low + box.high), 0.5 * (box.high - box.low))) return true;
  if (std::any_of(zones.begin(), zones.end(), [&](const Bounds& z) { return holds(z, box); })) return true;
  // It is cut where a zone begins or ends in it, else halved, as the other may be beside it.
  Eigen::Index axis = 0;
  const double size = (box.high - box.low).maxCoeff(&axis);
  double at = 0.5 * (box.low(axis) + box.high(axis));
  const auto zone = std::find_if(zones.begin(), zones.end(), [&](const Bounds& z) {
    const Bounds shared = both(z, box);
    return ((shared.high - shared.low).array() > 0.0).all();
  });
  if (zone != zones.end()) {
    for (int i = 0; i < 3; ++i) {
      for (const double face : {zone->low(i), zone->high(i)})
        if (face > box.low(i) && face < box.high(i)) axis = i, at = face;
    }
  } else if (size <= smallest) {
    return false;
  }
  Bounds low = box, high = box;
  low.high(axis) = high.low(axis) = at;
  return is_held(low, other, zones, smallest) && is_held(high, other, zones, smallest);
}

}  // namespace

std::vector<Bounds> part_boxes(const HexahedronTree& tree) {
  std::vector<Bounds> boxes;
  for (const PlacedHexahedron& each : tree.solids()) {
    Bounds& box = boxes.emplace_back();
    for (const Vector3& v : each.solid.vertices()) box.add(transform(each.X_OS, v));
    box.low -= Vector3::Constant(each.solid.radius());
    box.high += Vector3::Constant(each.solid.radius());
  }
  return boxes;
}

NearCells::NearCells(const MeshDistance& mesh, double beyond) {
  const Vector3 more = Vector3::Constant(beyond);
  low_ = mesh.bounds().low - more;
  const Vector3 size = mesh.bounds().high + more - low_;
  width_ = size.maxCoeff() / kCells;
  for (int axis = 0; axis < 3; ++axis)
    counts_[axis] = std::clamp(static_cast<int>(std::ceil(size(axis) / width_)), 1, kCells);
  const double reach = beyond + std::sqrt(0.75) * width_;
  for (Index cell{}; cell[0] < counts_[0]; ++cell[0])
    for (cell[1] = 0; cell[1] < counts_[1]; ++cell[1])
      for (cell[2] = 0; cell[2] < counts_[2]; ++cell[2])
        is_near_mesh_.push_back(mesh.to_solid(corner(cell) + Vector3::Constant(0.5 * width_)) <= reach ? 1
                                                                                                       : 0);
  is_marked_.assign(is_near_mesh_.size(), 0);
}

void NearCells::add(const SeenObject& other, double by) {
  // Poses are looked at that are a quarter of a cell apart, or as far as they are.
  const double slack = 0.125 * width_;
  double gone = 0.0;
  for (std::size_t i = 0; i < other.X_TO.size(); ++i) {
    const double strays = other.strays[i];
    gone += 2.0 * strays;
    const bool is_far = 2.0 * strays > slack;
    if (is_far) mark(other.parts_O, other.X_TO[i - 1], by + std::max(slack, strays));
    if (!is_far && i > 0 && i + 1 < other.X_TO.size() && gone <= slack) continue;
    mark(other.parts_O, other.X_TO[i], by + std::max(slack, strays));
    gone = 0.0;
  }
}

void NearCells::mark(std::span<const Bounds> parts_O, const Pose& X_TO, double by) {
  const Vector3 half = Vector3::Constant(0.5 * width_);
  for (const Bounds& part : parts_O) {
    const TurnedBox box(part, X_TO, by);
    const Bounds bounds = box.bounds();
    Index first, last;
    for (int axis = 0; axis < 3; ++axis) {
      const auto index = [&](double at) {
        return static_cast<int>(std::clamp(std::floor((at - low_(axis)) / width_), -1.0, kCells + 1.0));
      };
      first[axis] = std::max(index(bounds.low(axis)), 0);
      last[axis] = std::min(index(bounds.high(axis)), counts_[axis] - 1);
    }
    for (Index cell = first; cell[0] <= last[0]; ++cell[0]) {
      for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1]) {
        for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2]) {
          std::uint8_t& mark = is_marked_[at(cell)];
          if (mark == 0 && is_near_mesh_[at(cell)] != 0 && box.meets(corner(cell) + half, half)) mark = 1;
        }
      }
    }
  }
}

// Cells that count, the box about them, and the best place to divide it.
struct NearCells::Part {
  std::vector<Index> cells;
  Index first, last;
  std::size_t count;  // of cells near the mesh in the box
  int axis = 0, cut = 0;
  std::size_t gain = 0;  // of these, what dividing before `cut` leaves out
};

std::size_t NearCells::count_in(const Index& first, const Index& last) const {
  std::size_t count = 0;
  for (Index cell = first; cell[0] <= last[0]; ++cell[0])
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1])
      for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2]) count += is_near_mesh_[at(cell)];
  return count;
}

NearCells::Part NearCells::part_of(std::vector<Index> cells) const {
  // Cells near the mesh in the box about some cells.
  const auto count_about = [this](std::span<const Index> some, Index& first, Index& last) {
    first = last = some.front();
    for (const Index& cell : some) {
      for (int axis = 0; axis < 3; ++axis) {
        first[axis] = std::min(first[axis], cell[axis]);
        last[axis] = std::max(last[axis], cell[axis]);
      }
    }
    return count_in(first, last);
  };
  // The cut across an axis that leaves fewest of them in the boxes of both sides.
  Part part;
  part.count = count_about(cells, part.first, part.last);
  Index first, last;
  for (int axis = 0; axis < 3; ++axis) {
    std::stable_sort(cells.begin(), cells.end(),
                     [&](const Index& a, const Index& b) { return a[axis] < b[axis]; });
    for (std::size_t i = 1; i < cells.size(); ++i) {
      if (cells[i][axis] == cells[i - 1][axis]) continue;
      const std::span<const Index> all(cells);
      const std::size_t left =
          count_about(all.first(i), first, last) + count_about(all.subspan(i), first, last);
      if (part.count > left && part.count - left > part.gain) {
        part.gain = part.count - left;
        part.axis = axis;
        part.cut = cells[i][axis];
      }
    }
  }
  // A cut that gains little is not made.
  if (static_cast<double>(part.gain) < kLeastGain * static_cast<double>(part.count)) part.gain = 0;
  part.cells = std::move(cells);
  return part;
}

std::vector<Bounds> NearCells::boxes() const {
  std::vector<Index> marked;
  for (Index cell{}; cell[0] < counts_[0]; ++cell[0])
    for (cell[1] = 0; cell[1] < counts_[1]; ++cell[1])
      for (cell[2] = 0; cell[2] < counts_[2]; ++cell[2])
        if (is_marked_[at(cell)] != 0) marked.push_back(cell);
  if (marked.empty()) return {};
  // The part whose division saves most is divided next.
  std::vector<Part> parts = {part_of(std::move(marked))};
  while (parts.size() < kMostZones) {
    const auto most = std::max_element(parts.begin(), parts.end(),
                                       [](const Part& a, const Part& b) { return a.gain < b.gain; });
    if (most->gain == 0) break;
    const Part whole = std::move(*most);
    std::vector<Index> before, after;
    for (const Index& cell : whole.cells) (cell[whole.axis] < whole.cut ? before : after).push_back(cell);
    *most = part_of(std::move(before));
    parts.push_back(part_of(std::move(after)));
  }
  std::vector<Bounds> zones;
  for (const Part& part : parts)
    zones.push_back({corner(part.first), corner({part.last[0] + 1, part.last[1] + 1, part.last[2] + 1})});
  return zones;
}

bool are_held(std::span<const Bounds> boxes, const SeenObject& other, double margin,
              std::span<const Bounds> zones) {
  for (std::size_t i = 0; i < other.X_TO.size(); ++i) {
    // A point between two poses is near one of them.
    const double strays = std::max(other.strays[i], i + 1 < other.X_TO.size() ? other.strays[i + 1] : 0.0);
    for (const Bounds& part : other.parts_O) {
      const TurnedBox turned(part, other.X_TO[i], margin + strays);
      const Bounds about = turned.bounds();
      for (const Bounds& box : boxes) {
        const Bounds near = both(box, about);
        if (!is_empty(near) && !is_held(near, turned, zones, kFinest * margin)) return false;
      }
    }
  }
  return true;
}

}  // namespace touchstone::fitting
