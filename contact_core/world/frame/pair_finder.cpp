#include "touchstone/contact_core/world/frame/pair_finder.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

#include <algorithm>
#include <atomic>

namespace touchstone {
namespace {

/// Pairs, or roots, that a lane takes at once.
constexpr std::size_t kPairsAtOnce = 64;
constexpr std::size_t kRootsAtOnce = 16;
/// Rounds sums of travels down.
constexpr double kDown = 1.0 - 0x1p-50;

bool is_of_interest(const WorldModel& model, const FramePair& pair) {
  const bool starts_close = pair.impact.queries > 0 && pair.impact.start_separation <= pair.gap;
  return are_two_movers(model, pair.solids) || !pair.impact.is_far || starts_close ||
         pair.impact.starts_overlapping;
}

}  // namespace

void PairFinder::take_room(std::size_t slots, std::size_t solids, std::size_t watched) {
  impacts_.take_room(slots, solids), impacts_.take_room_for_pairs(watched);
  reserve_more(examined_, 64 + 16 * solids), reserve_more(opened_, 64 + 16 * solids);
  for (GrowingList<std::uint32_t>* list : {&touching_, &close_, &deferred_}) reserve_more(*list, watched);
  reserve_more(left_out_, watched);
}

// Those that touch come first, then all others that may be near at the start: where they stop a mover, the
// rest need only be clear up to there.
PairFinder::Counts PairFinder::find(const Scope& scope, std::span<const ContactState> contacts,
                                    GrowingList<FramePair>& pairs) {
  Counts counts;
  pairs.clear();
  scope.watched.gather(scope.model, scope.movers, scope.lanes, close_, deferred_);
  examine_touching(scope, contacts, pairs, counts);
  std::size_t known = pairs.size();
  examine(scope, close_, pairs, counts);
  merge_by_solids(pairs, known);
  erase_if(deferred_,
           [&](std::uint32_t i) { return is_clear_to_bounds(scope.model, scope.watched.pairs()[i]); });
  scope.watched.keep_checked(scope.model, scope.lanes, deferred_);
  known = pairs.size();
  examine(scope, deferred_, pairs, counts);
  merge_by_solids(pairs, known);
  impacts_.forget(scope.movers.roots);
  return counts;
}

/// Takes them out of close_.
void PairFinder::examine_touching(const Scope& scope, std::span<const ContactState> contacts,
                                  GrowingList<FramePair>& pairs, Counts& counts) {
  touching_.clear();
  if (contacts.empty()) return;
  erase_if(close_, [&](std::uint32_t i) {
    if (!is_among(contacts, scope.watched.pairs().solids(i))) return false;
    touching_.push_back(i);
    return true;
  });
  examine(scope, touching_, pairs, counts);
}

/// Finds the impacts of watched pairs and appends those to `pairs` that are not known to stay apart. Of a
/// mover the nearest come first, and each group of equally near ones bounds how far its path matters to all
/// after it.
/// @param watches by solids; switched on.
void PairFinder::examine(const Scope& scope, std::span<const std::uint32_t> watches,
                         GrowingList<FramePair>& pairs, Counts& counts) {
  if (watches.empty()) return;
  // Lanes fill one entry a pair.
  const std::size_t first = pairs.size(), last = first + watches.size();
  pairs.resize(last);
  examined_.resize(std::max(examined_.size(), last));
  place_vertices(scope.model, scope.lanes, scope.watched.pairs(), watches);
  scope.lanes.for_each(watches.size(), kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    examined_[first + i] = open_pair(scope, watches[i], pairs[first + i]);
  });
  // Pairs that stay open are measured where they stand, then advanced along their paths.
  counts.candidates += static_cast<std::uint32_t>(watches.size());
  opened_.clear();
  for (std::size_t k = first; k < last; ++k)
    if (examined_[k] == Stage::open) opened_.push_back(static_cast<std::uint32_t>(k));
  impacts_.find({scope.model, scope.lanes, scope.watched.pairs()}, pairs, opened_);
  // Pairs of no interest are removed, and the order is kept.
  std::size_t kept = first;
  for (std::size_t k = first; k < last; ++k) {
    if (examined_[k] != Stage::open) continue;
    counts.iteration_limits += pairs[k].impact.status == ImpactStatus::iteration_limit;
    if (!is_of_interest(scope.model, pairs[k])) continue;
    if (kept != k) pairs[kept] = pairs[k];
    ++kept;
  }
  pairs.resize(kept);
}

/// Fills in `entry`, unless the two are known to stay apart, wherever on their paths they are stopped.
PairFinder::Stage PairFinder::open_pair(const Scope& scope, std::uint32_t index, FramePair& entry) const {
  WorldModel& model = scope.model;
  WatchedPair& watch = scope.watched.pairs()[index];
  const SolidPair pair{watch.a, watch.b};
  entry = model.frame_pair(pair);
  entry.watch = index;
  const double last = model.last_travel(pair, entry.link_pair);
  const double standing = model.travelled(pair, entry.link_pair) * kDown - last * (1.0 + 0x1p-19);
  if (is_apart_by_axis(model, watch, entry, standing, last * impacts_.matters_until(model, pair)))
    return Stage::apart;
  entry.clear_until = watch.clear_until;
  return Stage::open;
}

/// Clear as far as its movers come by what is known so far.
bool PairFinder::is_clear_to_bounds(const WorldModel& model, const WatchedPair& watch) const {
  const Travels& travels = model.travels;
  const double a = impacts_.stop_bound(model.root_of(watch.a)),
               b = impacts_.stop_bound(model.root_of(watch.b));
  const double gone = watch.link_pair != kNoLinkPair
                          ? a * travels.last_link_pair[watch.link_pair]
                          : a * travels.last_solid[watch.a] + b * travels.last_solid[watch.b];
  const SolidPair pair{watch.a, watch.b};
  return (model.travelled(pair, watch.link_pair) - model.last_travel(pair, watch.link_pair)) + gone <=
         watch.clear_until;
}

void PairFinder::add_left_out(const Scope& scope, std::span<const ContactState> contacts,
                              GrowingList<FramePair>& pairs) {
  const std::size_t known = pairs.size();
  add_unclear_left_out(scope, contacts, pairs);
  for (const ContactState& contact : contacts)
    if (scope.model.is_checked(contact.solids) &&
        !is_among(std::span<const FramePair>(pairs).first(known), contact.solids))
      pairs.push_back(scope.model.frame_pair(contact.solids));
  merge_by_solids(pairs, known);
}

/// The watched pairs of movers that were stopped, if not known to be apart, into left_out_, by solids.
/// @returns how many.
std::size_t PairFinder::gather_left_out(const Scope& scope, std::span<const ContactState> contacts,
                                        std::span<const FramePair> known) {
  WorldModel& model = scope.model;
  WatchedPairs& watched = scope.watched;
  PairWatch& watches = watched.pairs();
  const GrowingList<std::uint8_t>& is_short = scope.movers.is_short;
  const std::vector<std::uint32_t>& roots = scope.movers.roots;
  std::atomic<std::size_t> count{0};
  // Of two movers that were stopped the pair comes from its a.
  const auto take = [&](std::uint32_t index, SolidIndex solid) {
    const WatchedPair& watch = watches[index];
    const SolidPair pair{watch.a, watch.b};
    if (model.is_clear(watch) || (solid != pair.a && is_short[model.root_of(pair.a)])) return;
    if (is_among(known, pair) || !model.is_checked(pair) || is_among(contacts, pair)) return;
    left_out_[count.fetch_add(1, std::memory_order_relaxed)] = {pair, index};
  };
  // Rigid movers look through the pairs of their solids, in lanes.
  left_out_.resize(std::max(left_out_.size(), std::size_t{watches.size()}));
  scope.lanes.for_each(roots.size(), kRootsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    if (!is_short[roots[i]] || model.mechanism_of(roots[i]) != nullptr) return;
    model.for_each_solid(roots[i], [&](SolidIndex solid) {
      watches.for_each_of(solid, [&](std::uint32_t index) { take(index, solid); });
    });
  });
  // Of an arm's many pairs most are known to be clear.
  for (const std::uint32_t root : roots) {
    if (!is_short[root] || model.mechanism_of(root) == nullptr) continue;
    watches.for_each_of_arms_beyond(
        [&](const WatchedPair& watch) {
          return model.travelled({watch.a, watch.b}, watch.link_pair);
        },
        [&](std::uint32_t index) {
          const auto [a, b] = watches.solids(index);
          if (model.root_of(a) == root || model.root_of(b) == root)
            take(index, model.root_of(a) == root ? a : b);
        });
  }
  // Sorting makes the order independent of lanes.
  std::sort(left_out_.begin(), left_out_.begin() + static_cast<std::ptrdiff_t>(count));
  return count;
}

void PairFinder::add_unclear_left_out(const Scope& scope, std::span<const ContactState> contacts,
                                      GrowingList<FramePair>& pairs) {
  WorldModel& model = scope.model;
  PairWatch& watches = scope.watched.pairs();
  const std::size_t known = pairs.size(), count = gather_left_out(scope, contacts, pairs);
  close_.clear();
  for (const GatheredPair& pair : std::span(left_out_).first(count)) close_.push_back(pair.watch);
  place_vertices(model, scope.lanes, watches, close_);
  pairs.resize(known + count);
  examined_.resize(std::max(examined_.size(), pairs.size()));
  scope.lanes.for_each(count, kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    WatchedPair& watch = watches[close_[i]];
    FramePair& entry = pairs[known + i] = model.frame_pair({watch.a, watch.b});
    const double standing = model.travelled(entry.solids, watch.link_pair) * kDown;
    const bool is_apart = is_apart_by_axis(model, watch, entry, standing, 0.0);
    examined_[known + i] = is_apart ? Stage::apart : Stage::open;
  });
  std::size_t kept = known;
  for (std::size_t k = known; k < pairs.size(); ++k) {
    if (examined_[k] == Stage::apart) continue;
    if (kept != k) pairs[kept] = pairs[k];
    ++kept;
  }
  pairs.resize(kept);
}

}  // namespace touchstone
