#include <algorithm>
#include <limits>

#include "touchstone/contact_core/world/world_state.hpp"

// Who stops whom, in one part of a frame, and when a pair's stop or touch was (Moment).
//
// In rounds: those pairs that meet first, all of them, stop their movers; then all that these could meet is
// looked at again, until no pair is open. No order of pairs shows. A pair that holds takes its movers back to
// their start: what these had stopped by then was stopped by a motion that is not executed, so the rounds
// begin again without it.

namespace touchstone {

/// @returns whether it undid a stop further on, which only a pair that holds brings about: in all else stops
/// come in their order.
bool ContactWorld::State::stop_movers(const FramePair& pair) {
  const double target = pair.holds() ? 0.0 : pair.impact.lo;
  bool undoes = false;
  for (const SolidIndex solid : {pair.solids.a, pair.solids.b}) {
    const std::uint32_t root = root_of(solid);
    if (!in_motion[root] || stops[root] < target) continue;
    const bool is_newly_held = pair.holds() && !is_held[root];
    is_held[root] = is_held[root] || pair.holds();
    slides.permits.note_stop(followers.leader_of(root), pair.rule,
                             stops[root] == target && stops[root] < 1.0);
    if (stops[root] == target) {
      if (is_newly_held) stop_together(root, target);  // who goes along is held as well
      continue;
    }
    took_back = took_back || pair.holds();
    undoes = undoes || (took_back && stops[root] < 1.0);
    stop_together(root, target);
  }
  return undoes;
}

/// Who goes along is stopped where its leader is, and the other way round.
void ContactWorld::State::stop_together(std::uint32_t root, double target) {
  const auto stop = [&](std::uint32_t one) {
    stops[one] = target;
    is_held[one] = is_held[root];
    if (is_restopped[one] == 0) restopped.push_back(one);
    is_restopped[one] = 1;
  };
  stop(root);
  if (followers.all().empty()) return;
  const std::uint32_t leader = followers.leader_of(root);
  stop(leader);
  for (const std::uint32_t follower : followers.all())
    if (followers.leader_of(follower) == leader) stop(follower);
}

/// All that are due at `least` take effect; but where a pair holds, only those that do, as they may undo the
/// others. @returns as stop_movers().
bool ContactWorld::State::settle(std::span<FramePair> among, double least, std::uint32_t part) {
  const std::span<const std::uint32_t> due_pairs = stop_queue.due();
  const bool only_holds = least > 0.0 && std::any_of(due_pairs.begin(), due_pairs.end(),
                                                     [&](std::uint32_t i) { return among[i].holds(); });
  // Of a motion that will not be executed: before any of it is taken back.
  for (const std::uint32_t i : due_pairs)
    if (among[i].holds() && among[i].stop == kNoMoment) among[i].stop = add_moment(among[i], part, least);
  bool undoes = false;
  for (const std::uint32_t i : due_pairs) {
    FramePair& pair = among[i];
    if (only_holds && !pair.holds()) {
      stop_queue.put(least, i);
      continue;
    }
    pair.is_settled = true;
    if (pair.stopped_at == kNotStopped && !pair.holds()) pair.stopped_at = least;
    if (stop_movers(pair)) undoes = true;
  }
  return undoes;
}

void ContactWorld::State::recheck(std::uint32_t root, std::span<FramePair> among) {
  for (const auto& [concerned, i] : stop_queue.of(root)) {
    FramePair& pair = among[i];
    const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
    const std::uint32_t other = a == root ? b : a;
    if (other != root && in_motion[other]) {
      pair.impact = impact_of(*this, *query, pair);
      pair.is_settled = false;
      if (pair.is_open()) stop_queue.put(pair.impact.lo, i);
    } else if (pair.impact.lo >= stops[root]) {
      pair.impact.status = ImpactStatus::clear;  // the path now ends before
    }
  }
}

/// As before the first round, but for movers that are held at their start.
void ContactWorld::State::begin_again(std::span<FramePair> among) {
  took_back = false;
  StopPermits& permits = slides.permits;
  for (const std::uint32_t root : movers) {
    permits.translation_only[root] = permits.translation_only_before[root];
    if (!in_motion[root]) continue;
    const double stop = is_held[root] ? 0.0 : 1.0;
    if (stops[root] != stop) is_restopped[root] = 1;
    stops[root] = stop;
    if (!is_held[root]) permits.may_slide[root] = permits.may_pivot[root] = 1;  // until the next stop says
  }
  for (FramePair& pair : among) {
    pair.stopped_at = kNotStopped;
    const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
    if (!is_restopped[a] && !is_restopped[b]) continue;
    pair.impact = impact_of(*this, *query, pair);
    pair.is_settled = false;
  }
  for (const std::uint32_t root : movers) is_restopped[root] = 0;
  restopped.clear();
  queue_open(among);
}

void ContactWorld::State::queue_open(std::span<const FramePair> among) {
  stop_queue.forget_times();
  for (std::uint32_t i = 0; i < among.size(); ++i)
    if (among[i].is_open()) stop_queue.put(among[i].impact.lo, i);
}

void ContactWorld::State::resolve_stops(std::span<FramePair> among, std::uint32_t part) {
  StopPermits& permits = slides.permits;
  for (const std::uint32_t root : movers)
    is_held[root] = 0, permits.translation_only_before[root] = permits.translation_only[root];
  took_back = false;
  restopped.clear(), stop_queue.clear();
  for (std::uint32_t i = 0; i < among.size(); ++i) {
    const std::uint32_t a = root_of(among[i].solids.a), b = root_of(among[i].solids.b);
    if (in_motion[a]) stop_queue.concern(a, i);
    if (a != b && in_motion[b]) stop_queue.concern(b, i);
  }
  stop_queue.order_roots();
  queue_open(among);
  // The cap is a safeguard: then nothing moves, which is allowed, and is said. Each new beginning holds at
  // least one mover more, so there are no more of them than movers.
  const std::size_t most = 16 + 8 * std::size_t{layout.slots()};
  std::size_t round = 0;
  while (round < most) {
    const double least = stop_queue.take_first(
        [&](double s, std::uint32_t i) { return among[i].is_open() && among[i].impact.lo == s; });
    if (least == std::numeric_limits<double>::infinity()) return;
    if (settle(among, least, part)) {
      begin_again(among);
      round = 0;
      continue;
    }
    ++round;
    for (const std::uint32_t root : restopped) {
      recheck(root, among);
      is_restopped[root] = 0;
    }
    restopped.clear();
  }
  for (const std::uint32_t root : movers) stops[root] = 0.0;
  for (FramePair& pair : among)
    if (pair.stopped_at > 0.0) pair.stopped_at = kNotStopped;
}

/// With the pair at s of the paths that are laid, up to their stops so far.
std::uint32_t ContactWorld::State::add_moment(const FramePair& pair, std::uint32_t part, double s) {
  PairGeometry geometry{};
  const bool is_known =
      pair.own == kNotOwn && pair.impact.lo == s &&
      (pair.impact.status == ImpactStatus::blocked || pair.impact.status == ImpactStatus::iteration_limit);
  if (is_known) {
    geometry = pair.impact.geometry;
  } else {
    query->set_pair(pair.solids);
    query->separation(moving_solid(pair.solids.a).pose_at(s), moving_solid(pair.solids.b).pose_at(s),
                      geometry);
  }
  moments.push_back({part, s, geometry});
  return static_cast<std::uint32_t>(moments.size() - 1);
}

/// Once a part is executed: what its stops came to.
void ContactWorld::State::note_moments(std::span<FramePair> among, std::uint32_t part) {
  for (FramePair& pair : among) {
    if (pair.touch == kNoMoment) note_touch(pair, part);
    if (pair.stopped_at != kNotStopped && pair.stop == kNoMoment) {
      const bool is_touch = pair.touch != kNoMoment && moments[pair.touch].part == part &&
                            moments[pair.touch].s == pair.stopped_at;
      pair.stop = is_touch ? pair.touch : add_moment(pair, part, pair.stopped_at);
    }
    pair.stopped_at = kNotStopped;
  }
}

void ContactWorld::State::note_touch(FramePair& pair, std::uint32_t part) {
  const Impact& impact = pair.impact;
  if (impact.queries == 0 || is_among(contacts, pair.solids)) return;
  const bool starts_close = impact.start_separation <= pair.gap && !query->judges_poses();
  const bool starts = starts_close || impact.starts_overlapping;
  const bool meets = pair.stopped_at != kNotStopped || impact.status != ImpactStatus::clear;
  if (!starts && !meets) return;
  const double s = starts ? 0.0 : pair.stopped_at != kNotStopped ? pair.stopped_at : impact.lo;
  const std::uint32_t moment = add_moment(pair, part, s);
  // Where poses are judged, what a cue lets go on past the last clear one is in contact from there.
  const bool is_entry = query->judges_poses() && pair.rule.policy == ContactPolicy::cue;
  if (starts || is_entry || moments[moment].geometry.separation <= pair.gap)
    pair.touch = moment;
  else
    moments.pop_back();
}

/// Of pairs that hold back a sub-step's plan: as all stand now, at the end of `part`.
void ContactWorld::State::note_active(std::uint32_t part) {
  for (FramePair& pair : slides.pairs.pairs()) {
    if (!pair.is_active || pair.stop != kNoMoment) continue;
    PairGeometry geometry{};
    query->set_pair(pair.solids);
    query->separation(from[pair.solids.a], from[pair.solids.b], geometry);
    if (!(geometry.separation <= 2.0 * pair.gap)) continue;
    pair.stop = static_cast<std::uint32_t>(moments.size());
    moments.push_back({part, 1.0, geometry});
    const bool touches = pair.touch == kNoMoment && geometry.separation <= pair.gap;
    if (touches && !is_among(contacts, pair.solids)) pair.touch = pair.stop;
  }
}

}  // namespace touchstone
