#include "touchstone/physics/contacts/gap_narrowphase.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics {
namespace {

/// The answer about a pair beyond max_separation.
PairGeometry far_apart() {
  const Vector3 none = Vector3::Constant(kNaN);
  return {kInfinity, none, none, none, 0};
}

}  // namespace

GapNarrowphase::GapNarrowphase(std::unique_ptr<Narrowphase> inner, double gap,
                               std::shared_ptr<const SeenPairs> seen)
    : inner_(std::move(inner)), gap_(gap), seen_(std::move(seen)) {
  if (!inner_) throw InputError("gap: no narrowphase given");
  const Capabilities& can = inner_->capabilities();
  if (!can.manifold || !can.distance || !can.penetration)
    throw InputError("narrowphase '" + std::string(inner_->name()) +
                     "' has no contact points, or no distances or depths");
  if (!(gap_ >= 0.0) || !std::isfinite(gap_)) throw InputError("gap: it must be finite and >= 0");
}

/// Solids apart by no more than the gap touch; undecided and overlapping ones stay so, deeper.
void GapNarrowphase::bring_nearer(PairStatus& status, PairGeometry& geometry,
                                  std::span<ContactPoint> points) const {
  if (status == PairStatus::failed || status == PairStatus::unsupported ||
      !std::isfinite(geometry.separation))
    return;
  geometry.separation -= gap_;
  geometry.p_B_W -= gap_ * geometry.n_AB_W;
  if (status == PairStatus::separated && geometry.separation <= 0.0) status = PairStatus::overlapping;
  for (ContactPoint& point :
       points.first(std::min(points.size(), static_cast<std::size_t>(geometry.point_count)))) {
    point.separation -= gap_;
    point.p_B_W -= gap_ * geometry.n_AB_W;
  }
}

void GapNarrowphase::evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                              Workspace& workspace) const noexcept {
  if (input.query.kind == QueryKind::overlap) {
    for (PairStatus& status : output.status) status = PairStatus::unsupported;
    return;
  }
  NarrowphaseInput further = input;
  further.query.max_separation += gap_;
  further.query.max_point_separation += gap_;
  inner_->evaluate(further, output, workspace);
  for (std::size_t i = 0; i < input.pairs.size(); ++i) {
    if (!seen_->sees(input.pairs[i])) {
      output.status[i] = PairStatus::separated;
      output.geometry[i] = far_apart();
      continue;
    }
    bring_nearer(output.status[i], output.geometry[i], output.points_of(i, input.query));
  }
}

}  // namespace touchstone::physics
