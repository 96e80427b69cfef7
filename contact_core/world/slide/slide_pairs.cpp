#include "touchstone/contact_core/world/slide/slide_pairs.hpp"

#include <algorithm>
#include <atomic>
#include <tuple>
#include <utility>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/world/slide/slide_reach.hpp"

namespace touchstone {
namespace {

/// Rounds sums of travels down.
constexpr double kDown = 1.0 - 0x1p-50;
/// Pairs that a lane takes at once.
constexpr std::size_t kSlidersAtOnce = 16;
constexpr std::size_t kPairsAtOnce = 64;

/// The slider beside this one that is in the pair, or null.
const Slider* other_slider(const SlidePairs::Scope& scope, const Slider& slider, SolidIndex obstacle) {
  const Slider* other = scope.sliders.find(scope.model.root_of(obstacle));
  return other == nullptr || other == &slider || other->done ? nullptr : other;
}

/// How far the solid that is not the slider's can still come; 0: it does not slide, or with the slider.
double other_reach(const SlidePairs::Scope& scope, const Slider& slider, const SolidPair& pair) {
  const auto [mover, obstacle] = scope.model.mover_first(pair, slider.root);
  const Slider* other = other_slider(scope, slider, obstacle);
  return other == nullptr ? 0.0 : slide_reach(scope.model, *other, obstacle, mover);
}

/// Of one mover; or of two of which one takes the other along, or a third both.
bool go_as_one(const SlidePairs::Scope& scope, const SolidPair& pair) {
  const std::uint32_t a = scope.model.root_of(pair.a), b = scope.model.root_of(pair.b);
  return scope.sliders.leader_of(a) == scope.sliders.leader_of(b);
}

/// Whether a rigid slider could come to meet what it is watched with.
bool is_reached(const SlidePairs::Scope& scope, const Slider& slider, const WatchedPair& watch) {
  const WorldModel& model = scope.model;
  const SolidPair pair{watch.a, watch.b};
  if (go_as_one(scope, pair)) return false;
  // At rest it has at least so much left.
  const double left = watch.clear_until - model.travelled(pair, watch.link_pair);
  return !(left > reach_of_pair(model, slider, pair) + other_reach(scope, slider, pair));
}

/// Whether a pair stays apart on an arm's plan, the path that is laid, along the axis that parted it last: a
/// link that goes by close to a face would be near by how far it goes.
bool is_passed_by(const SlidePairs::Scope& scope, const Slider& slider, const FramePair& pair) {
  const WorldModel& model = scope.model;
  const WatchedPair& watch = scope.watched[pair.watch];
  if (scope.query.judges_poses() || scope.sliders.list.size() > 1 || watch.axis_W == Vector3::Zero())
    return false;
  const auto [a, b] = pair.solids;
  MovingSolid first = model.moving_solid(a), second = model.moving_solid(b);
  if (pair.link_pair != kNoLinkPair) {
    const double travel = model.travels.planned_link_pair[pair.link_pair];
    std::tie(first, second) = model.seen_from_earlier_link(pair.solids, travel);
  } else {
    first.travel = model.travels.planned_solid[a], second.travel = model.travels.planned_solid[b];
  }
  first.stop = model.root_of(a) == slider.root ? 1.0 : 0.0;
  second.stop = model.root_of(b) == slider.root ? 1.0 : 0.0;
  return stays_apart_along(first, second, watch.axis_W, pair.interest);
}

}  // namespace

void SlidePairs::reserve(std::size_t slots, std::size_t solids, std::size_t mechanisms) {
  reserve_more(pairs_, 64 + 16 * solids), reserve_more(near_, 64 + 16 * solids);
  held_.reserve(mechanisms * kMostSlideRows);
  reserve_more(short_of_pairs_, slots), reserve_more(ranges_, slots);
  impacts_.take_room(slots, solids);
}

void SlidePairs::reserve_watched(std::size_t watched) {
  reserve_more(met_, 2 * watched), reserve_more(taken_in_, 2 * watched);
  reserve_more(pair_of_, watched), reserve_more(is_near_, watched), reserve_more(passed_on_, watched);
  reserve_more(close_, watched), reserve_more(open_, watched), reserve_more(ahead_, watched);
  reserve_more(unclear_, 2 * watched), reserve_more(watches_, watched);
  impacts_.take_room_for_pairs(watched);
}

std::span<const std::uint32_t> SlidePairs::begin(WorldModel& model, const Sliders& sliders) {
  forget_watches();
  pairs_.clear(), held_.clear(), short_of_pairs_.clear();
  // Of all objects, of which there may be many more than slide: only what an earlier slide has noted.
  if (std::exchange(has_noted_needs_, false)) {
    Travels& travels = model.travels;
    std::fill(travels.needed.begin(), travels.needed.end(), 0.0);
    std::fill(travels.needed_object.begin(), travels.needed_object.end(), 0.0);
  }
  for (const Slider& slider : sliders.list) {
    if (slider.arm != nullptr || slider.done) continue;
    has_noted_needs_ = true;
    model.for_each_member(slider.root, [&](std::uint32_t slot) {
      // The watch takes the last path, gone by now, from its reserve.
      if (needs_more_pairs(model, slider, slot)) short_of_pairs_.push_back(slot);
    });
  }
  return short_of_pairs_;
}

/// What is noted by watched pair is of pairs_ alone: there are many more that are watched.
void SlidePairs::forget_watches() {
  for (const FramePair& pair : pairs_)
    if (pair.watch != kNoIndex)
      pair_of_[pair.watch] = kNoIndex, is_near_[pair.watch] = 0, passed_on_[pair.watch] = 0;
}

void SlidePairs::renumber(const PairWatch& watched) {
  forget_watches();
  const std::size_t size = std::max<std::size_t>(watched.size(), pair_of_.size());
  pair_of_.resize(size, kNoIndex), is_near_.resize(size, 0), passed_on_.resize(size, 0);
  for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
    pairs_[i].watch = kNoIndex;
    const std::uint32_t watch = watched.find(pairs_[i].solids);
    if (watch == kNoIndex) continue;
    pairs_[i].watch = watch;
    pair_of_[watch] = i;
  }
}

void SlidePairs::gather(const WorldModel& model, const PairWatch& watched, const Sliders& sliders,
                        FrameLanes& lanes) {
  ranges_.clear(), met_.clear();
  if (sliders.is_one_arm()) return;
  // The first pass counts each slider's pairs.
  for (const Slider& slider : sliders.list) ranges_.push_back({slider.root, 0, 0});  // by root
  lanes.for_each(ranges_.size(), kSlidersAtOnce, [&](NarrowphaseQuery&, std::size_t k) {
    model.for_each_solid(ranges_[k].root, [&](SolidIndex i) {
      watched.for_each_of(i, [&](std::uint32_t) { ++ranges_[k].end; });
    });
  });
  // The counts give each slider its range of the list.
  std::uint32_t room = 0;
  for (Range& range : ranges_) {
    range.begin = room;
    room += range.end;
  }
  met_.resize(room);
  // The second pass fills the ranges and sorts them.
  lanes.for_each(ranges_.size(), kSlidersAtOnce, [&](NarrowphaseQuery&, std::size_t k) {
    Range& range = ranges_[k];
    range.end = range.begin;
    model.for_each_solid(range.root, [&](SolidIndex i) {
      watched.for_each_of(i, [&](std::uint32_t index) {
        // A pair of two solids of the slider is taken from its a.
        const bool is_inner = model.root_of(watched[index].a) == model.root_of(watched[index].b);
        if (!is_inner || watched[index].a == i) met_[range.end++] = index;
      });
    });
    if (sliders.list[k].pivots) return;  // it plans with none of them
    std::sort(met_.begin() + range.begin, met_.begin() + range.end,
              [&](std::uint32_t x, std::uint32_t y) { return watched.solids(x) < watched.solids(y); });
  });
}

template <class Visit>
void SlidePairs::for_each_of(const Slider& slider, Visit visit) const {
  const auto range = std::lower_bound(ranges_.begin(), ranges_.end(), slider.root,
                                      [](const Range& x, std::uint32_t root) { return x.root < root; });
  if (range == ranges_.end() || range->root != slider.root) return;
  for (std::uint32_t i = range->begin; i < range->end; ++i) visit(met_[i]);
}

template <class Gone, class Visit>
void SlidePairs::for_each_beyond(const Scope& scope, const Slider& arm, Gone gone, Visit visit) {
  PairWatch& watched = scope.watched;
  watched.for_each_of_arms_beyond(gone, [&](std::uint32_t index) {
    const auto [a, b] = watched.solids(index);
    if (scope.model.root_of(a) == arm.root || scope.model.root_of(b) == arm.root) visit(index);
  });
}

/// Its index in pairs_, or kNoIndex where it is not checked.
std::uint32_t SlidePairs::take_in(const WorldModel& model, const PairWatch& watched, std::uint32_t watch) {
  std::uint32_t& index = pair_of_[watch];
  const SolidPair pair = watched.solids(watch);
  if (index == kNoIndex && model.is_checked(pair)) {
    index = static_cast<std::uint32_t>(pairs_.size());
    pairs_.push_back(model.frame_pair(pair));
    pairs_.back().watch = watch;
  }
  return index;
}

void SlidePairs::nothing_is_active() {
  for (FramePair& pair : pairs_) pair.is_active = false;
}

/// Those that may not be clear on the paths that are laid, by solids.
void SlidePairs::find_close(const Scope& scope) {
  WorldModel& model = scope.model;
  PairWatch& watched = scope.watched;
  FrameLanes& lanes = scope.lanes;
  const bool is_one_arm = scope.sliders.is_one_arm();
  unclear_.resize(std::max(unclear_.size(), is_one_arm ? std::size_t{watched.count()} : met_.size()));
  // No path has the number 0. Where another one moves as well, none is passed by.
  const std::uint64_t path = is_one_arm ? scope.sliders.list[0].arm->paths : 0;
  // Lanes collect the pairs that are not clear and of which one moves.
  std::atomic<std::size_t> count{0};
  const auto take = [&](std::uint32_t index) {
    const WatchedPair& watch = watched[index];
    if (model.is_clear(watch) || (path != 0 && passed_on_[index] == path)) return;
    if (model.in_motion[model.root_of(watch.a)] || model.in_motion[model.root_of(watch.b)])
      unclear_[count.fetch_add(1, std::memory_order_relaxed)] = {{watch.a, watch.b}, index};
  };
  if (is_one_arm)
    for_each_beyond(
        scope, scope.sliders.list[0],
        [&](const WatchedPair& watch) {
          return model.travelled({watch.a, watch.b}, watch.link_pair);
        },
        take);
  lanes.for_each(ranges_.size(), kSlidersAtOnce, [&](NarrowphaseQuery&, std::size_t k) {
    for (std::uint32_t i = ranges_[k].begin; i < ranges_[k].end; ++i) take(met_[i]);
  });
  // Sorting makes the order independent of lanes; a pair that was found from both sides is kept once.
  const auto end = unclear_.begin() + static_cast<std::ptrdiff_t>(count);
  std::sort(unclear_.begin(), end);
  const auto unique_end = std::unique(
      unclear_.begin(), end, [](const GatheredPair& a, const GatheredPair& b) { return a.watch == b.watch; });
  const std::span<const GatheredPair> found(unclear_.begin(), unique_end);
  // The pairs join the slide's list; those that are seen in the world can be asked about in one batch.
  take_in_all(scope, found);
  close_.clear();
  for (const GatheredPair& each : found)
    if (const std::uint32_t index = pair_of_[each.watch]; index != kNoIndex) close_.push_back(index);
}

/// As take_in(), of many.
void SlidePairs::take_in_all(const Scope& scope, std::span<const GatheredPair> found) {
  WorldModel& model = scope.model;
  taken_in_.assign(found.size(), 0);
  scope.lanes.for_each(found.size(), kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    taken_in_[i] = pair_of_[found[i].watch] == kNoIndex && model.is_checked(found[i].solids);
  });
  const std::size_t before = pairs_.size();
  for (std::size_t i = 0; i < found.size(); ++i)
    if (taken_in_[i]) put_in(found[i].solids, found[i].watch);
  fill_in(scope, before);
}

/// fill_in() does the rest, in lanes.
void SlidePairs::put_in(SolidPair pair, std::uint32_t watch) {
  pair_of_[watch] = static_cast<std::uint32_t>(pairs_.size());
  pairs_.emplace_back();
  pairs_.back().solids = pair, pairs_.back().watch = watch;
}

void SlidePairs::fill_in(const Scope& scope, std::size_t before) {
  scope.lanes.for_each(pairs_.size() - before, kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    FramePair& pair = pairs_[before + i];
    const std::uint32_t watch = pair.watch;
    pair = scope.model.frame_pair(pair.solids);
    pair.watch = watch;
  });
}

std::uint32_t SlidePairs::find_impacts(const Scope& scope) {
  constexpr std::size_t kFew = 128;
  // Results of the sub-step before are cleared.
  for (FramePair& pair : pairs_) {
    pair.is_settled = false;
    pair.impact.status = ImpactStatus::clear;
    pair.impact.queries = 0;  // of the sub-step before
  }
  find_close(scope);
  // Of many pairs those are left out that are still apart along a known axis.
  const bool is_limited = scope.meter.is_limited();
  if (close_.size() >= kFew && !is_limited)
    keep_unclear(scope);
  else
    open_.assign(close_.begin(), close_.end());
  // Pairs that were near count against the budget, which may end the search: then nothing is executed.
  std::uint32_t limits = 0;
  const auto count = [&](const FramePair& pair) {
    if (is_near_on_path(scope.model, pair)) scope.meter.add_pair();
    limits += pair.impact.status == ImpactStatus::iteration_limit;
    return scope.meter.may_go_on();
  };
  const NearestImpacts::Scope asking{scope.model, scope.lanes, scope.watched};
  for (const Slider& slider : scope.sliders.list) impacts_.forget({&slider.root, 1});
  if (is_limited) {
    impacts_.find_in_turn(asking, pairs_, open_, count);
  } else {
    impacts_.find(asking, pairs_, open_);
    for (const std::uint32_t index : open_) count(pairs_[index]);
  }
  for (const Slider& slider : scope.sliders.list) impacts_.forget({&slider.root, 1});
  return limits;
}

/// By how it stands, whatever was known of it before.
bool SlidePairs::is_near_on_path(const WorldModel& model, const FramePair& pair) {
  return pair.impact.queries > 0 &&
         !(pair.impact.start_separation - model.last_travel(pair.solids, pair.link_pair) > pair.interest);
}

void SlidePairs::add_looks(const WorldModel& model, Sliders& sliders) const {
  for (const std::uint32_t index : open_) {
    const FramePair& pair = pairs_[index];
    if (!is_near_on_path(model, pair)) continue;
    // The looks count as the shover's work, also those at what goes along.
    const std::uint32_t a = sliders.leader_of(model.root_of(pair.solids.a)),
                        b = sliders.leader_of(model.root_of(pair.solids.b));
    const auto looks = static_cast<std::uint64_t>(pair.impact.queries);
    if (Slider* slider = sliders.find(a)) slider->work += looks;
    if (Slider* slider = a == b ? nullptr : sliders.find(b)) slider->work += looks;
  }
}

/// Of those in close_, into open_.
void SlidePairs::keep_unclear(const Scope& scope) {
  constexpr std::size_t kClosePairsAtOnce = 32;
  WorldModel& model = scope.model;
  PairWatch& watched = scope.watched;
  watches_.clear();
  for (const std::uint32_t index : close_) watches_.push_back(pairs_[index].watch);
  place_vertices(model, scope.lanes, watched, watches_);
  scope.lanes.for_each(close_.size(), kClosePairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    FramePair& pair = pairs_[close_[i]];
    WatchedPair& watch = watched[pair.watch];
    const double last = model.last_travel(pair.solids, pair.link_pair);
    const double standing = model.travelled(pair.solids, pair.link_pair) * kDown - last * (1.0 + 0x1p-19);
    if (is_apart_by_axis(model, watch, pair, standing, last)) watches_[i] = kNoIndex;
  });
  open_.clear();
  for (std::size_t i = 0; i < close_.size(); ++i)
    if (watches_[i] != kNoIndex) open_.push_back(close_[i]);
}

/// @returns false: the two are further apart than they could come.
bool SlidePairs::make_near(const Scope& scope, NarrowphaseQuery& query, const Slider& slider,
                           std::uint32_t source, NearPair& near) const {
  const WorldModel& model = scope.model;
  const FramePair& pair = pairs_[source];
  const auto [mover, obstacle] = model.mover_first(pair.solids, slider.root);
  const bool is_b = mover == pair.solids.b;
  const Pose &X_WA = model.from[pair.solids.a], &X_WB = model.from[pair.solids.b];
  // Contact points are needed only as far out as the two could come together.
  near.centre_W = slide_centre(model, slider, mover);
  near.reach = reach_of_pair(model, slider, pair.solids);
  const double furthest = near.reach + other_reach(scope, slider, pair.solids) + 2.0 * pair.gap;
  query.set_pair(pair.solids);
  PairGeometry geometry{};
  if (!has_geometry(query.manifold(X_WA, X_WB, furthest, geometry, near.points))) return false;
  if (!(geometry.separation < furthest)) return false;
  // The pair is described from the slider's side.
  near.mover = &model.layout.solids[mover], near.obstacle = &model.layout.solids[obstacle];
  near.X_WM = model.from[mover], near.X_WB = model.from[obstacle];
  near.gap = pair.gap;
  near.source = source;
  if (slider.arm != nullptr) {
    near.link = model.objects[model.body_of(mover)].link;
    near.other_link = other_link(model, slider, obstacle);
  }
  // The normal points from the obstacle to the mover.
  near.separation = geometry.separation;
  near.n = is_b ? geometry.n_AB_W : Vector3(-geometry.n_AB_W);
  near.point_count = geometry.point_count;
  if (!is_b)
    for (int i = 0; i < near.point_count; ++i) std::swap(near.points[i].p_A_W, near.points[i].p_B_W);
  // Two sliders share the room between them.
  if (const Slider* other = other_slider(scope, slider, obstacle))
    near.share =
        share_between(slider, model.objects[slider.root].X_WO, *other, model.objects[other->root].X_WO, near);
  classify(near);
  return true;
}

void SlidePairs::add_near(const Scope& scope, const Slider& slider, std::uint32_t source) {
  NearPair near;
  if (!make_near(scope, scope.query, slider, source, near)) return;
  near_.push_back(near);
  scope.meter.add_pair();
}

void SlidePairs::take_in_reached(const Scope& scope, std::span<const std::uint8_t> plans) {
  taken_in_.assign(met_.size(), 0);
  scope.lanes.for_each(ranges_.size(), kSlidersAtOnce, [&](NarrowphaseQuery&, std::size_t k) {
    if (!plans[k]) return;
    for (std::uint32_t i = ranges_[k].begin; i < ranges_[k].end; ++i)
      taken_in_[i] = is_reached(scope, scope.sliders.list[k], scope.watched[met_[i]]) &&
                     scope.model.is_checked(scope.watched.solids(met_[i]));
  });
  const std::size_t before = pairs_.size();
  for (std::size_t i = 0; i < met_.size(); ++i)
    if (taken_in_[i] && pair_of_[met_[i]] == kNoIndex) put_in(scope.watched.solids(met_[i]), met_[i]);
  fill_in(scope, before);
}

void SlidePairs::find_near_taken_in(const Scope& scope, NarrowphaseQuery& query, const Slider& slider,
                                    std::vector<NearPair>& out) const {
  out.clear();
  for_each_of(slider, [&](std::uint32_t index) {
    if (!is_reached(scope, slider, scope.watched[index])) return;
    const std::uint32_t source = pair_of_[index];
    if (source == kNoIndex || pairs_[source].rule.policy != ContactPolicy::slide) return;
    NearPair near;
    if (make_near(scope, query, slider, source, near)) out.push_back(near);
  });
}

void SlidePairs::find_near(const Scope& scope, const Slider& slider) {
  WorldModel& model = scope.model;
  near_.clear();
  if (slider.arm != nullptr) {
    for (const FramePair& pair : pairs_)
      if (pair.watch != kNoIndex) is_near_[pair.watch] = 0;
    std::fill(model.travels.planned_solid.begin(), model.travels.planned_solid.end(), 0.0);
    std::fill(model.travels.planned_link_pair.begin(), model.travels.planned_link_pair.end(), 0.0);
    ++model.travels.clearings;
    add_on_path(scope, slider);
    return;
  }
  bool may_go_on = true;
  for_each_of(slider, [&](std::uint32_t index) {
    if (!may_go_on) return;
    if (!is_reached(scope, slider, scope.watched[index])) return;
    const std::uint32_t source = take_in(model, scope.watched, index);
    if (source == kNoIndex || pairs_[source].rule.policy != ContactPolicy::slide) return;
    may_go_on = scope.meter.may_go_on();
    if (may_go_on) add_near(scope, slider, source);
  });
}

/// Whether a pair that is taken in is further apart than `approach` and what is of interest: then this is
/// noted.
bool SlidePairs::stays_apart(const Scope& scope, std::uint32_t watch, double approach) {
  const WorldModel& model = scope.model;
  NarrowphaseQuery& query = scope.query;
  if (query.judges_poses()) return false;  // separations say nothing about what such a backend sees
  const FramePair& pair = pairs_[pair_of_[watch]];
  PairGeometry geometry{};
  query.set_pair(pair.solids);
  if (query.separation(model.from[pair.solids.a], model.from[pair.solids.b], geometry) !=
      PairStatus::separated)
    return false;
  // The gap is far more than separations and sums round.
  const double room = geometry.separation - pair.interest - pair.gap;
  scope.watched[watch].axis_W = geometry.n_AB_W;
  if (!(room > 0.0)) return false;
  double& clear_until = scope.watched[watch].clear_until;
  clear_until = std::max(clear_until, model.travelled(pair.solids, pair.link_pair) * kDown + room);
  return room > approach;
}

/// Gathers into close_ the pairs that an arm's plan could bring together, by travels and axes; by solids.
void SlidePairs::gather_on_path(const Scope& scope, const Slider& slider) {
  WorldModel& model = scope.model;
  ahead_.clear(), close_.clear(), unclear_.clear();
  const PairDistances most = model.most_distances();
  // A plan brings two solids together by at most what they travel on it.
  const auto approach_of = [&](const WatchedPair& watch) {
    const Travels& travels = model.travels;
    const double planned = watch.link_pair != kNoLinkPair
                               ? travels.planned_link_pair[watch.link_pair]
                               : travels.planned_solid[watch.a] + travels.planned_solid[watch.b];
    return scope.sliders.list.size() > 1 ? planned + other_reach(scope, slider, {watch.a, watch.b}) : planned;
  };
  // Pairs that the plan cannot bring together, by travels or along a known axis, are left out.
  const auto leave_out = [&](std::uint32_t index) {
    WatchedPair& watch = scope.watched[index];
    const SolidPair pair{watch.a, watch.b};
    const double approach = approach_of(watch);
    if (model.travelled(pair, watch.link_pair) + approach <= watch.clear_until || is_near_[index]) return;
    if (watch.link_pair == kNoLinkPair && go_as_one(scope, pair)) return;
    // Mostly it is, and its rule need not be looked up for that.
    const double standing = model.travelled(pair, watch.link_pair) * kDown;
    if (!is_apart_by_axis(model, watch, most, standing, approach)) unclear_.push_back({pair, index});
  };
  const auto gone_by_plan = [&](const WatchedPair& watch) {
    return model.travelled({watch.a, watch.b}, watch.link_pair) + approach_of(watch);
  };
  if (scope.sliders.is_one_arm())
    for_each_beyond(scope, slider, gone_by_plan, leave_out);
  else
    for_each_of(slider, leave_out);
  // The rest are taken in by solids and tried once more with the distances of their rule.
  std::sort(unclear_.begin(), unclear_.end());
  for (const GatheredPair& found : unclear_) {
    const std::uint32_t source = take_in(model, scope.watched, found.watch);
    if (source == kNoIndex) continue;
    FramePair& met = pairs_[source];
    WatchedPair& watch = scope.watched[found.watch];
    const double approach = approach_of(watch);
    const double standing = model.travelled(found.solids, watch.link_pair) * kDown;
    const bool is_same = met.gap == most.gap && met.interest == most.interest;
    if (!is_same && is_apart_by_axis(model, watch, met, standing, approach)) continue;
    met.approach = approach;
    close_.push_back(source), ahead_.push_back(found.solids);
  }
}

bool SlidePairs::add_on_path(const Scope& scope, const Slider& slider) {
  const std::size_t before = near_.size();
  gather_on_path(scope, slider);
  scope.query.look_ahead(ahead_, scope.model.from);
  for (const std::uint32_t source : close_) {
    const FramePair& pair = pairs_[source];
    if (stays_apart(scope, pair.watch, pair.approach)) continue;
    if (is_passed_by(scope, slider, pair)) {
      passed_on_[pair.watch] = slider.arm->paths;
      continue;
    }
    is_near_[pair.watch] = 1;
    if (pair.rule.policy != ContactPolicy::slide) continue;
    if (!scope.meter.may_go_on()) return false;
    add_near(scope, slider, source);
  }
  return near_.size() > before;
}

bool SlidePairs::add_held(const Scope& scope, const Slider& slider) {
  const std::size_t before = near_.size();
  for (const HeldPair& held : held_) {
    const std::uint32_t watch = pairs_[held.source].watch;
    if (held.root != slider.root || watch == kNoIndex || is_near_[watch]) continue;
    is_near_[watch] = 1;
    add_near(scope, slider, held.source);
  }
  return near_.size() > before;
}

void SlidePairs::forget_held(const Slider& slider) {
  std::erase_if(held_, [&](const HeldPair& held) { return held.root == slider.root; });
}

void SlidePairs::note_held(const Slider& slider, std::uint32_t source) {
  const bool is_noted = std::any_of(held_.begin(), held_.end(), [&](const HeldPair& held) {
    return held.root == slider.root && held.source == source;
  });
  if (!is_noted) held_.push_back({slider.root, source});
}

void merge_slide_pairs(WorldModel& model, PairWatch& watched, std::span<const ContactState> contacts,
                       std::span<FramePair> met_pairs, GrowingList<FramePair>& pairs) {
  const auto by_solids = [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; };
  const std::size_t known = pairs.size();
  for (FramePair& met : met_pairs) {
    if (met.watch != kNoIndex) met.clear_until = watched[met.watch].clear_until;
    // A pair that the frame knows already keeps its entry and takes the slide's moments.
    const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(known);
    const auto place = std::lower_bound(pairs.begin(), end, met, by_solids);
    if (place != end && place->solids == met.solids) {
      place->impact.is_far = false;
      if (place->stop == kNoMoment) place->stop = met.stop;
      if (place->touch == kNoMoment) place->touch = met.touch;
      continue;
    }
    // Pairs known to be further apart than any distance of interest have nothing to report.
    const double gone = model.travelled(met.solids, met.link_pair);
    const bool may_matter = met.has_moment() || is_among(contacts, met.solids);
    if (!may_matter && gone <= met.clear_until) continue;
    if (!may_matter && met.watch != kNoIndex &&
        is_apart_by_axis(model, watched[met.watch], met, gone * kDown, 0.0))
      continue;
    // The others are added as they are at the slide's end.
    met.impact.is_far = false;
    met.impact.starts_overlapping = false;  // a sub-step's start is not the frame's
    pairs.push_back(met);
  }
  merge_by_solids(pairs, known);
}

}  // namespace touchstone
