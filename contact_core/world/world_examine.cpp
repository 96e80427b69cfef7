#include <algorithm>
#include <limits>

#include "touchstone/contact_core/world/world_state.hpp"

// Which of the watched pairs matter in a frame, and when they meet: axes, then separations where the solids
// stand, then conservative advancement. Pairs of one mover depend on each other, as what stops it bounds how
// far all others matter; movers do not: lanes (frame_lanes.hpp) take them in any order.

namespace touchstone {
namespace {

/// So many pairs, or movers, a lane takes at once.
constexpr std::size_t kPairsAtOnce = 64;
constexpr std::size_t kMoversAtOnce = 8;

}  // namespace

// Those that may be near at the start come first: where they stop a mover, all others need only be clear up
// to there.
void ContactWorld::State::find_pairs(FrameReport& report) {
  if (is_watch_due()) watch_pairs();
  pairs.clear();
  gather_unclear();
  for (const std::uint32_t root : movers) stop_bounds[root] = 1.0;
  examine(close, report);
  std::erase_if(deferred, [&](std::uint32_t i) { return is_clear_to_bounds(watched[i]); });
  const std::size_t known = pairs.size();
  examine(deferred, report);
  merge_by_solids(pairs, known);
}

/// Finds the impacts of watched pairs and appends those to `pairs` that are not known to stay apart. Of a
/// mover the nearest come first, and each group of equally near ones bounds how far its path matters to all
/// after it.
/// @param watches by solids; switched on.
void ContactWorld::State::examine(std::span<const std::uint32_t> watches, FrameReport& report) {
  if (watches.empty()) return;
  const std::size_t first = pairs.size(), last = first + watches.size();
  pairs.resize(last);
  examined.resize(std::max(examined.size(), last));
  place_vertices(*this, lanes, watched, watches);
  lanes.for_each(watches.size(), kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    examined[first + i].stage = open_pair(watches[i], pairs[first + i]);
  });
  opened.clear();
  report.candidate_pairs += static_cast<std::uint32_t>(watches.size());
  for (std::size_t k = first; k < last; ++k) {
    if (examined[k].stage == PairStage::open)
      opened.push_back({mover_of(*this, pairs[k].solids), static_cast<std::uint32_t>(k)});
  }
  measure_opened();
  find_impacts_of_opened();
  std::size_t kept = first;
  for (std::size_t k = first; k < last; ++k) {
    if (examined[k].stage != PairStage::open) continue;
    report.iteration_limits += pairs[k].impact.status == ImpactStatus::iteration_limit;
    if (!is_of_interest(pairs[k])) continue;
    if (kept != k) pairs[kept] = pairs[k];
    ++kept;
  }
  pairs.resize(kept);
}

/// How far a pair's path matters: up to where what is known so far stops its mover. Of two movers in motion
/// one may be stopped before the other.
double ContactWorld::State::matters_until(const SolidPair& pair) const {
  const std::uint32_t a = root_of(pair.a), b = root_of(pair.b);
  if (a != b && in_motion[a] && in_motion[b]) return 1.0;
  return stop_bounds[in_motion[a] ? a : b];
}

/// Fills in `entry`, unless the two are known to stay apart, wherever on their paths they are stopped.
PairStage ContactWorld::State::open_pair(std::uint32_t watch, FramePair& entry) {
  const SolidPair pair{watched[watch].a, watched[watch].b};
  entry = frame_pair(pair);
  entry.watch = watch;
  const double last = last_travel(pair, entry.own);
  const double standing = travelled(pair, entry.own) * (1.0 - 0x1p-50) - last * (1.0 + 0x1p-19);
  if (is_apart_by_axis(*this, watched[watch], entry, standing, last * matters_until(pair)))
    return PairStage::apart;
  entry.clear_until = watched[watch].clear_until;
  return PairStage::open;
}

/// Where all stand. Pairs of a mechanism's own links come last: they are seen from a link, and in other
/// poses.
void ContactWorld::State::measure_opened() {
  ahead.clear();
  for (const OpenedPair& open : opened)
    if (pairs[open.index].own == kNotOwn) ahead.push_back(pairs[open.index].solids);
  answers.resize(std::max(answers.size(), ahead.size()));
  lanes.ask(ahead, from, answers);
  std::size_t answer = 0;
  for (OpenedPair& open : opened) {
    FramePair& pair = pairs[open.index];
    pair.start_separation = std::numeric_limits<double>::infinity();
    examined[open.index].start = kNotAsked;
    if (pair.own == kNotOwn) {
      const double separation = answers[answer].geometry.separation;
      if (separation < pair.start_separation) pair.start_separation = separation;
      examined[open.index].start = static_cast<std::uint32_t>(answer++);
    }
    open.start_separation = pair.start_separation;
  }
}

/// By mover, the nearest first.
void ContactWorld::State::find_impacts_of_opened() {
  std::sort(opened.begin(), opened.end());
  opened_groups.clear();
  for (std::size_t i = 0; i < opened.size(); ++i)
    if (i == 0 || opened[i].mover != opened[i - 1].mover || opened[i].mover == kAlone)
      opened_groups.push_back(static_cast<std::uint32_t>(i));
  const auto group = [&](std::size_t i) {
    const std::size_t end = i + 1 < opened_groups.size() ? opened_groups[i + 1] : opened.size();
    return std::span(opened).subspan(opened_groups[i], end - opened_groups[i]);
  };
  lanes.for_each(opened_groups.size(), kMoversAtOnce, [&](NarrowphaseQuery& asking, std::size_t i) {
    if (group(i).front().mover != kInTurn) find_impacts_of_mover(asking, group(i));
  });
  for (std::size_t i = 0; i < opened_groups.size(); ++i)
    if (group(i).front().mover == kInTurn) find_impacts_of_mover(lanes.first(), group(i));
}

void ContactWorld::State::find_impacts_of_mover(NarrowphaseQuery& asking, std::span<const OpenedPair> among) {
  std::size_t bounded = 0;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (among[i].start_separation > among[bounded].start_separation) {
      for (; bounded < i; ++bounded) bound_stops(pairs[among[bounded].index]);
    }
    FramePair& pair = pairs[among[i].index];
    const std::uint32_t start = examined[among[i].index].start;
    find_impact_of(*this, asking, watched[pair.watch], pair, start == kNotAsked ? nullptr : &answers[start],
                   matters_until(pair.solids));
    if (pair.impact.status == ImpactStatus::clear) pair.impact.lo = 1.0;  // what is beyond a stop is not gone
  }
  for (; bounded < among.size(); ++bounded) bound_stops(pairs[among[bounded].index]);
}

bool ContactWorld::State::is_of_interest(const FramePair& pair) const {
  const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
  const bool both = a != b && in_motion[a] && in_motion[b];
  const bool starts_close = pair.impact.queries > 0 && pair.impact.start_separation <= pair.gap;
  return both || !pair.impact.is_far || starts_close || pair.impact.starts_overlapping;
}

/// What one mover meets by itself ends its path there, whatever else happens.
void ContactWorld::State::bound_stops(const FramePair& pair) {
  const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
  if (!pair.stops_movers() || (a != b && in_motion[a] && in_motion[b])) return;
  for (const std::uint32_t root : {a, b})
    if (in_motion[root]) stop_bounds[root] = std::min(stop_bounds[root], pair.impact.lo);
}

}  // namespace touchstone
