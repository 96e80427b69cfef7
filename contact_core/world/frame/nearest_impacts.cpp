#include "touchstone/contact_core/world/frame/nearest_impacts.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

/// Movers that a lane takes at once.
constexpr std::size_t kMoversAtOnce = 8;

}  // namespace

void NearestImpacts::take_room(std::size_t slots, std::size_t solids) {
  resize_more(stop_bounds_, slots, 1.0);
  reserve_more(answers_, 64 + 16 * solids);
  reserve_more(opened_, 64 + 16 * solids), reserve_more(groups_, 64 + 16 * solids);
}

double NearestImpacts::matters_until(const WorldModel& model, const SolidPair& pair) const {
  if (are_two_movers(model, pair)) return 1.0;
  const std::uint32_t a = model.root_of(pair.a);
  return stop_bounds_[model.in_motion[a] ? a : model.root_of(pair.b)];
}

void NearestImpacts::find(const Scope& scope, std::span<FramePair> pairs,
                          std::span<const std::uint32_t> open) {
  measure(scope, pairs, open);
  const auto all = [](const FramePair&) { return true; };
  scope.lanes.for_each(groups_.size(), kMoversAtOnce, [&](NarrowphaseQuery& asking, std::size_t i) {
    if (group(i).front().mover != kInTurn) find_of_mover(scope, asking, group(i), pairs, all);
  });
  for (std::size_t i = 0; i < groups_.size(); ++i)
    if (group(i).front().mover == kInTurn) find_of_mover(scope, scope.lanes.first(), group(i), pairs, all);
}

/// Where all stand. Pairs of a mechanism's own links come last: they are seen from a link, and in other
/// poses.
void NearestImpacts::measure(const Scope& scope, std::span<FramePair> pairs,
                             std::span<const std::uint32_t> open) {
  opened_.clear(), ahead_.clear(), groups_.clear();
  for (const std::uint32_t index : open)
    if (pairs[index].link_pair == kNoLinkPair) ahead_.push_back(pairs[index].solids);
  answers_.resize(std::max(answers_.size(), ahead_.size()));
  scope.lanes.ask(ahead_, scope.model.from, answers_);
  // They are sorted by mover and by how far apart they are.
  std::uint32_t answer = 0;
  for (const std::uint32_t index : open) {
    FramePair& pair = pairs[index];
    Opened out{mover_of(scope.model, pair.solids), index, kNotAsked, kInfinity};
    if (pair.link_pair == kNoLinkPair) {
      const double separation = answers_[answer].geometry.separation;
      if (separation < out.start_separation) out.start_separation = separation;
      out.start = answer++;
    }
    pair.start_separation = out.start_separation;
    opened_.push_back(out);
  }
  std::sort(opened_.begin(), opened_.end());
  for (std::size_t i = 0; i < opened_.size(); ++i)
    if (i == 0 || opened_[i].mover != opened_[i - 1].mover || opened_[i].mover == kAlone)
      groups_.push_back(static_cast<std::uint32_t>(i));
}

/// Of one mover, or a single pair.
std::span<const NearestImpacts::Opened> NearestImpacts::group(std::size_t i) const {
  const std::size_t end = i + 1 < groups_.size() ? groups_[i + 1] : opened_.size();
  return std::span<const Opened>(opened_).subspan(groups_[i], end - groups_[i]);
}

/// A mover's contact with anything at rest ends its path there, whatever else happens.
void NearestImpacts::bound_stops(const WorldModel& model, const FramePair& pair) {
  if (!pair.stops_movers() || are_two_movers(model, pair.solids)) return;
  for (const std::uint32_t root : {model.root_of(pair.solids.a), model.root_of(pair.solids.b)})
    if (model.in_motion[root]) stop_bounds_[root] = std::min(stop_bounds_[root], pair.impact.lo);
}

}  // namespace touchstone
