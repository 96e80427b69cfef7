#include "touchstone/examples/station/flight/near_distances.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/native.hpp"

namespace touchstone::station {
namespace {

std::size_t largest_tree(const SceneInstance& instance) {
  std::size_t most = 0;
  for (const HexahedronTree* tree : instance.trees()) most = std::max(most, tree->solids().size());
  return most;
}

}  // namespace

NearDistances::NearDistances(const training::Setting& setting)
    : setting_(&setting),
      narrowphase_(make_native()),
      X_WS_(setting.instance().solids().size()),
      found_(setting.object_count() + 1) {
  narrowphase_->build(setting.instance().solids());
  workspace_ = narrowphase_->make_workspace();
  const std::size_t most = largest_tree(setting.instance());
  pairs_.reserve(most * most);
  status_.resize(most * most);
  geometry_.resize(most * most);
}

void NearDistances::place(std::uint32_t object, const Pose& X_WO) noexcept {
  const HexahedronTree& tree = *setting_->instance().trees()[object];
  find_global_positions(
      tree, X_WO, std::span(X_WS_).subspan(setting_->instance().first_solid(object), tree.solids().size()));
}

NearDistance NearDistances::nearest(std::uint32_t a, std::uint32_t b) noexcept {
  const SceneInstance& instance = setting_->instance();
  const bool in_order = a < b;
  const std::uint32_t first = in_order ? a : b, second = in_order ? b : a;
  // Every solid of the one against every solid of the other, the lower object first.
  pairs_.clear();
  for (SolidIndex i = 0; i < instance.trees()[first]->solids().size(); ++i)
    for (SolidIndex k = 0; k < instance.trees()[second]->solids().size(); ++k)
      pairs_.push_back({instance.first_solid(first) + i, instance.first_solid(second) + k});
  Query query;
  query.kind = QueryKind::distance;
  query.max_separation = kReach;
  narrowphase_->evaluate(
      {pairs_, X_WS_, query},
      {std::span(status_).first(pairs_.size()), std::span(geometry_).first(pairs_.size()), {}}, *workspace_);
  // The least, seen from a.
  NearDistance out;
  out.object = b;
  out.separation = kInfinity;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (!(geometry_[i].separation < out.separation)) continue;
    out.separation = geometry_[i].separation;
    out.solids = in_order ? pairs_[i] : SolidPair{pairs_[i].b, pairs_[i].a};
    out.p_A_W = in_order ? geometry_[i].p_A_W : geometry_[i].p_B_W;
    out.p_B_W = in_order ? geometry_[i].p_B_W : geometry_[i].p_A_W;
  }
  return out;
}

double NearDistances::between(std::uint32_t a, std::uint32_t b, std::span<const Pose> X_WO) noexcept {
  place(a, X_WO[a]);
  place(b, X_WO[b]);
  return nearest(a, b).separation;
}

void NearDistances::find(std::uint32_t object, std::span<const Pose> X_WO,
                         const training::Formation& formation) noexcept {
  // Objects whose spheres are further apart are not asked about.
  const auto spheres_are_near = [&](std::uint32_t a, std::uint32_t b) {
    const Sphere& at_a = setting_->instance().trees()[a]->nodes()[0].sphere_O;
    const Sphere& at_b = setting_->instance().trees()[b]->nodes()[0].sphere_O;
    return norm(transform(X_WO[a], at_a.centre) - transform(X_WO[b], at_b.centre)) <=
           at_a.radius + at_b.radius + kReach;
  };
  const auto count = static_cast<std::uint32_t>(X_WO.size());
  const auto moves_along = [&](std::uint32_t i) { return i == object || formation.root_of(i) == object; };
  for (std::uint32_t i = 0; i < count; ++i) place(i, X_WO[i]);
  // Objects that move along count as the object itself; of each other one the least distance is kept.
  count_ = 0;
  for (std::uint32_t other = 0; other < count; ++other) {
    const bool is_own =
        setting_->arm_of(object) != nullptr && setting_->arm_of(other) == setting_->arm_of(object);
    if (moves_along(other) || is_own || !formation.is_on[other]) continue;
    NearDistance least;
    least.separation = kInfinity;
    for (std::uint32_t mine = 0; mine < count; ++mine) {
      if (!moves_along(mine) || !spheres_are_near(mine, other)) continue;
      const NearDistance found = nearest(mine, other);
      if (found.separation < least.separation) least = found;
    }
    if (least.separation < kInfinity) found_[count_++] = least;
  }
  std::sort(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const NearDistance& a, const NearDistance& b) {
              return a.separation != b.separation ? a.separation < b.separation : a.object < b.object;
            });
  count_ = std::min(count_, kMost);
}

}  // namespace touchstone::station
