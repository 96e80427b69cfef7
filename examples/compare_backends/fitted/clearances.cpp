#include "touchstone/examples/compare_backends/fitted/clearances.hpp"

#include <algorithm>
#include <array>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"

namespace touchstone::comparison {
namespace {

HexahedronTree tree_of(const Hexahedron& probe) {
  std::vector<PlacedHexahedron> solids;
  solids.push_back({"probe", probe, Pose()});
  return HexahedronTree(std::move(solids), "probe");
}

}  // namespace

ClearanceQuery::ClearanceQuery(const FittedCover& cover, const ClearancePoses& poses,
                               std::unique_ptr<Narrowphase> narrowphase)
    : probe_(tree_of(poses.probe)),
      cover_(cover.tree),
      range_(poses.range),
      broadphase_(make_native_broadphase()),
      narrowphase_(std::move(narrowphase)) {
  std::vector<Hexahedron> solids{poses.probe};
  poses_.emplace_back();
  for (const PlacedHexahedron& each : cover_.solids()) {
    solids.push_back(each.solid);
    poses_.push_back(each.X_OS);
  }
  narrowphase_->build(solids);
  workspace_ = narrowphase_->make_workspace();
  const std::array<const HexahedronTree*, 2> trees = {&probe_, &cover_};
  const std::array<std::uint8_t, 2> is_static = {0, 1};
  broadphase_->build({trees, range_, is_static, nullptr});
  pairs_.resize(cover_.solids().size());
  status_.resize(pairs_.size());
  geometry_.resize(pairs_.size());
}

Clearance ClearanceQuery::operator()(const Pose& X_MP) {
  poses_[0] = X_MP;
  constexpr std::array<std::uint32_t, 1> kMoved = {0};
  broadphase_->update(poses_, kMoved);
  PairCursor cursor;
  const std::size_t count = broadphase_->find_pairs(cursor, pairs_);
  const std::span<const SolidPair> pairs = std::span<const SolidPair>(pairs_).first(count);
  const double start = processor_us();
  narrowphase_->evaluate({pairs, poses_, {.kind = QueryKind::distance, .max_separation = range_}},
                         {std::span(status_).first(count), std::span(geometry_).first(count)}, *workspace_);
  narrowphase_ns_ += 1e3 * (processor_us() - start);
  // The least of the pairs' is the union's.
  Clearance result{kInfinity, true, true, count};
  for (std::size_t i = 0; i < count; ++i) {
    if (status_[i] == PairStatus::failed || status_[i] == PairStatus::unsupported) {
      result.is_known = false;
    } else if (status_[i] == PairStatus::overlapping) {
      result.value = 0.0;
    } else {
      result.is_decided = result.is_decided && status_[i] != PairStatus::undecided;
      result.value = std::min(result.value, std::max(geometry_[i].separation, 0.0));
    }
  }
  return result;
}

}  // namespace touchstone::comparison
