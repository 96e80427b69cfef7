#include "touchstone/contact_core/world/frame/stop_resolver.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

#include <algorithm>

namespace touchstone {

void StopResolver::take_room(std::size_t slots, std::size_t solids, bool anew) {
  for (GrowingList<std::uint8_t>* flags : {&is_restopped_, &is_held_}) {
    if (anew) flags->clear();
    resize_more(*flags, slots);
  }
  reserve_more(restopped_, slots);
  queue_.reserve(64 + 16 * solids);
}

void StopResolver::resolve(const Scope& scope, std::span<FramePair> among, std::uint32_t part) {
  begin(scope, among);
  // The cap is a safeguard: then nothing moves, which is allowed, and the stops say so. Each new beginning
  // holds at least one mover more, so there are no more of them than movers.
  const std::size_t most = 16 + 8 * std::size_t{scope.model.layout.slots()};
  std::size_t round = 0;
  while (round < most) {
    // The earliest stop is settled first.
    const double least = queue_.take_first(
        [&](double s, std::uint32_t i) { return among[i].is_open() && among[i].impact.lo == s; });
    if (least == kInfinity) return;
    if (settle(scope, among, least, part)) {
      // Motion was taken back: all stops are found anew.
      begin_again(scope, among);
      round = 0;
      continue;
    }
    // Pairs of the movers that it stopped are checked again.
    ++round;
    for (const std::uint32_t root : restopped_) {
      recheck(scope, root, among);
      is_restopped_[root] = 0;
    }
    restopped_.clear();
  }
  // At the cap no mover leaves its start.
  for (const std::uint32_t root : scope.movers) scope.model.stops[root] = 0.0;
  for (FramePair& pair : among)
    if (pair.stopped_at > 0.0) pair.stopped_at = kNotStopped;
}

void StopResolver::begin(const Scope& scope, std::span<const FramePair> among) {
  const WorldModel& model = scope.model;
  StopPermits& permits = scope.permits;
  for (const std::uint32_t root : scope.movers)
    is_held_[root] = 0, permits.translation_only_before[root] = permits.translation_only[root];
  took_back_ = false;
  restopped_.clear(), queue_.clear();
  for (std::uint32_t i = 0; i < among.size(); ++i) {
    const std::uint32_t a = model.root_of(among[i].solids.a), b = model.root_of(among[i].solids.b);
    if (model.in_motion[a]) queue_.concern(a, i);
    if (a != b && model.in_motion[b]) queue_.concern(b, i);
  }
  queue_.order_roots();
  queue_open(among);
}

void StopResolver::queue_open(std::span<const FramePair> among) {
  queue_.forget_times();
  for (std::uint32_t i = 0; i < among.size(); ++i)
    if (among[i].is_open()) queue_.put(among[i].impact.lo, i);
}

/// All that are due at `least` take effect; but where a pair holds, only those that do, as they may undo the
/// others. @returns as stop_movers().
bool StopResolver::settle(const Scope& scope, std::span<FramePair> among, double least, std::uint32_t part) {
  const std::span<const std::uint32_t> due_pairs = queue_.due();
  const bool only_holds = least > 0.0 && std::any_of(due_pairs.begin(), due_pairs.end(),
                                                     [&](std::uint32_t i) { return among[i].holds(); });
  // Of a motion that will not be executed: before any of it is taken back.
  for (const std::uint32_t i : due_pairs)
    if (among[i].holds() && among[i].stop == kNoMoment)
      among[i].stop = scope.moments.add(scope.model, scope.query, among[i], part, least);
  bool undoes = false;
  for (const std::uint32_t i : due_pairs) {
    FramePair& pair = among[i];
    if (only_holds && !pair.holds()) {
      queue_.put(least, i);
      continue;
    }
    pair.is_settled = true;
    if (pair.stopped_at == kNotStopped && !pair.holds()) pair.stopped_at = least;
    if (stop_movers(scope, pair)) undoes = true;
  }
  return undoes;
}

/// @returns whether it undid a stop further on, which only a pair that holds brings about: all other stops
/// come in their order.
bool StopResolver::stop_movers(const Scope& scope, const FramePair& pair) {
  const WorldModel& model = scope.model;
  const double target = pair.holds() ? 0.0 : pair.impact.lo;
  bool undoes = false;
  for (const SolidIndex solid : {pair.solids.a, pair.solids.b}) {
    const std::uint32_t root = model.root_of(solid);
    const double stop = model.stops[root];
    if (!model.in_motion[root] || stop < target) continue;
    const bool is_newly_held = pair.holds() && !is_held_[root];
    is_held_[root] = is_held_[root] || pair.holds();
    scope.permits.note_stop(scope.followers.leader_of(root), pair.rule, stop == target && stop < 1.0);
    if (stop == target) {
      if (is_newly_held) stop_together(scope, root, target);  // who goes along is held as well
      continue;
    }
    took_back_ = took_back_ || pair.holds();
    undoes = undoes || (took_back_ && stop < 1.0);
    stop_together(scope, root, target);
  }
  return undoes;
}

/// Followers are stopped where their leader is, and the other way round.
void StopResolver::stop_together(const Scope& scope, std::uint32_t root, double target) {
  const Followers& followers = scope.followers;
  const auto stop = [&](std::uint32_t one) {
    scope.model.stops[one] = target;
    is_held_[one] = is_held_[root];
    if (is_restopped_[one] == 0) restopped_.push_back(one);
    is_restopped_[one] = 1;
  };
  stop(root);
  if (followers.all().empty()) return;
  const std::uint32_t leader = followers.leader_of(root);
  stop(leader);
  for (const std::uint32_t follower : followers.all())
    if (followers.leader_of(follower) == leader) stop(follower);
}

void StopResolver::recheck(const Scope& scope, std::uint32_t root, std::span<FramePair> among) {
  const WorldModel& model = scope.model;
  for (const auto& [concerned, i] : queue_.of(root)) {
    FramePair& pair = among[i];
    const std::uint32_t a = model.root_of(pair.solids.a), b = model.root_of(pair.solids.b);
    const std::uint32_t other = a == root ? b : a;
    if (other != root && model.in_motion[other]) {
      pair.impact = impact_of(model, scope.query, pair);
      pair.is_settled = false;
      if (pair.is_open()) queue_.put(pair.impact.lo, i);
    } else if (pair.impact.lo >= model.stops[root]) {
      pair.impact.status = ImpactStatus::clear;  // the path now ends before
    }
  }
}

/// As before the first round, but for movers that are held at their start.
void StopResolver::begin_again(const Scope& scope, std::span<FramePair> among) {
  WorldModel& model = scope.model;
  StopPermits& permits = scope.permits;
  took_back_ = false;
  for (const std::uint32_t root : scope.movers) {
    permits.translation_only[root] = permits.translation_only_before[root];
    if (!model.in_motion[root]) continue;
    const double stop = is_held_[root] ? 0.0 : 1.0;
    if (model.stops[root] != stop) is_restopped_[root] = 1;
    model.stops[root] = stop;
    if (!is_held_[root]) permits.may_slide[root] = permits.may_pivot[root] = 1;  // until the next stop
  }
  for (FramePair& pair : among) {
    pair.stopped_at = kNotStopped;
    const std::uint32_t a = model.root_of(pair.solids.a), b = model.root_of(pair.solids.b);
    if (!is_restopped_[a] && !is_restopped_[b]) continue;
    pair.impact = impact_of(model, scope.query, pair);
    pair.is_settled = false;
  }
  for (const std::uint32_t root : scope.movers) is_restopped_[root] = 0;
  restopped_.clear();
  queue_open(among);
}

}  // namespace touchstone
