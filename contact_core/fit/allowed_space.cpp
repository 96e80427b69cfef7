#include "touchstone/contact_core/fit/allowed_space.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone::fit {
namespace {

constexpr double kRoot3 = 1.7320508075688772;

bool touches(const Bounds& box, const Vector3& centre, double half) {
  return ((box.low - centre).array() <= half).all() && ((centre - box.high).array() <= half).all();
}

}  // namespace

struct AllowedSpace::Query {
  const SixPlanes& solid;
  Bounds box;
  std::array<double, 6> reach;  ///< |n.x| + |n.y| + |n.z| of each plane
};

AllowedSpace::AllowedSpace(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes)
    : mesh_(mesh), over_(over), boxes_(boxes.begin(), boxes.end()) {
  const Bounds& all = mesh.bounds();
  const double half = 0.5 * (all.high - all.low).maxCoeff() + 1.01 * over;
  cells_.push_back(make_cell(0.5 * (all.low + all.high), half, nullptr));
}

double AllowedSpace::limit_at(const Vector3& p) const {
  double limit = over_;
  for (const LimitBox& each : boxes_)
    if (touches(each.box, p, 0.0)) limit = std::min(limit, each.limit);
  return limit;
}

AllowedSpace::Cell AllowedSpace::make_cell(const Vector3& centre, double half, const Cell* parent) const {
  double least = over_;
  for (const LimitBox& each : boxes_)
    if (touches(each.box, centre, half)) least = std::min(least, each.limit);
  if (parent == nullptr) return {centre, half, mesh_.signed_distance(centre), limit_at(centre), least, 0};
  // Distances change by at most the way from the parent's centre; so does no sign that is farther off.
  const double way = kRoot3 * half, known = std::abs(parent->distance);
  const double distance = mesh_.nearest(centre, known + way).distance;
  const bool is_inside = known > way * (1.0 + 1e-9) ? parent->distance < 0.0 : mesh_.is_inside(centre);
  return {centre, half, is_inside ? -distance : distance, limit_at(centre), least, 0};
}

void AllowedSpace::divide(std::uint32_t cell) {
  const Cell parent = cells_[cell];
  const Vector3 centre = parent.centre;
  const double half = 0.5 * parent.half;
  cells_[cell].children = static_cast<std::uint32_t>(cells_.size());
  for (int i = 0; i < 8; ++i)
    cells_.push_back(make_cell(centre + half * Vector3((i & 4) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                                                       (i & 1) != 0 ? 1.0 : -1.0),
                               half, &parent));
}

bool AllowedSpace::is_violated(const Query& query, std::uint32_t index) {
  const Cell cell = cells_[index];
  if (cell.distance + kRoot3 * cell.half <= cell.least_limit) return false;
  if (!touches(query.box, cell.centre, cell.half)) return false;
  double highest = -1e300;
  for (int f = 0; f < 6; ++f) {
    const double height = query.solid.planes[f].signed_distance(cell.centre);
    if (height > cell.half * query.reach[f]) return false;
    highest = std::max(highest, height);
  }
  if (highest <= 0.0 && cell.distance > cell.limit) return true;
  if (cell.half <= cell.least_limit / 16.0) return cell.distance > cell.limit;
  if (cell.children == 0) divide(index);
  const std::uint32_t children = cells_[index].children;
  for (std::uint32_t i = 0; i < 8; ++i)
    if (is_violated(query, children + i)) return true;
  return false;
}

bool AllowedSpace::allows(const SixPlanes& solid) {
  Query query{solid, {}, {}};
  const Cell root = cells_[0];
  for (const Vector3& corner : solid.corners()) {
    if ((corner - root.centre).cwiseAbs().maxCoeff() > root.half) return false;
    query.box.add(corner);
  }
  for (int f = 0; f < 6; ++f) {
    const Vector3 n = solid.planes[f].normal.cwiseAbs();
    query.reach[f] = n.x() + n.y() + n.z();
  }
  for (const Vector3& corner : solid.corners())
    if (mesh_.nearest(corner).distance > limit_at(corner) && !mesh_.is_inside(corner)) return false;
  return !is_violated(query, 0);
}

}  // namespace touchstone::fit
