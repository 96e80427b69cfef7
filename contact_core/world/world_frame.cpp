#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/world/world_state.hpp"

// One frame: commands, paths, pairs. Stops are in world_stops.cpp, what is reported in world_events.cpp.

namespace touchstone {
namespace {

bool is_finite(const RigidPath& path) { return is_valid_pose(path.from()) && is_valid_pose(path.to()); }

}  // namespace

void ContactWorld::State::take_selection() {
  queue.take(changes);
  refused_changes.clear();
  std::size_t kept = 0;
  for (const SelectionChange& change : changes) {
    if (!selection.apply(change, objects, mechanisms)) {
      refused_changes.push_back(change);
      continue;
    }
    if (record.size() < record_room)
      record.push_back({frame, change});
    else
      ++left_out;
    changes[kept++] = change;
  }
  changes.resize(kept);
}

/// Whoever was told to move in the frame before rests, until a command says otherwise.
void ContactWorld::State::forget_motion() {
  told_before.swap(told);
  told.clear();
  movers.clear();
  for (const std::uint32_t slot : told_before) {
    for (std::vector<std::uint8_t>* flags : {&in_motion, &is_short, &is_held, &is_restopped,
                                             &slides.may_slide, &slides.may_pivot, &slides.translation_only})
      (*flags)[slot] = 0;
    stops[slot] = stop_bounds[slot] = 1.0;
    if (objects[slot].is_root(slot))
      paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_body());
  }
}

void ContactWorld::State::accept(std::span<const MotionCommand> commands) {
  for (const MotionCommand& command : commands) {
    if (!objects.may_move(command.object) || !is_finite(command.path)) {
      events.push_back(command_event(EventKind::refused, command.object));
      continue;
    }
    const std::uint32_t slot = command.object.slot;
    const Pose& X_WO = objects[slot].X_WO;
    const bool starts_here = command.path.from().R == X_WO.R && command.path.from().p == X_WO.p;
    const RigidPath path = starts_here ? command.path : RigidPath::between(X_WO, command.path.to());
    paths[slot] = CarriedPath(path, objects.poses_in_body());
    in_motion[slot] = !path.at_rest();
    movers.push_back(slot), told.push_back(slot);
    objects[slot].commanded = command.path.to();
  }
}

void ContactWorld::State::take_movers() {
  std::sort(movers.begin(), movers.end());
  movers.erase(std::unique(movers.begin(), movers.end()), movers.end());
  std::erase_if(movers, [&](std::uint32_t slot) { return !in_motion[slot]; });
}

void ContactWorld::State::lay_paths() {
  for (const std::uint32_t slot : moved)
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      travels.last_solid[solid] = 0.0;
  moved.clear();
  std::fill(travels.last_own.begin(), travels.last_own.end(), 0.0);
  for (const std::uint32_t root : movers)
    if (in_motion[root]) lay_travels(root);
  std::sort(moved.begin(), moved.end());
}

/// Of the object's frame; centre and rates are its body's.
BodyState ContactWorld::State::state_at(std::uint32_t slot, double s) const {
  const MechanismMover* mover = mechanism_of(slot);
  if (mover == nullptr) return paths[objects[slot].root].at(slot, s);
  BodyState state = mover->path.at(objects[objects[slot].body].link, s);
  if (objects[slot].body != slot) state.X_WO = compose(state.X_WO, objects.poses_in_body()[slot]);
  return state;
}

double ContactWorld::State::gap_of(const SolidPair& pair) const {
  const Resolution& resolution = separations().capabilities().resolution;
  // What is carried rounds as its body does, which may be further out.
  const auto reach = [&](SolidIndex i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    const double body = objects[body_of(i)].X_WO.p.cwiseAbs().maxCoeff();
    return std::max(body, from[i].p.cwiseAbs().maxCoeff()) + norm(sphere.centre) + 2.0 * sphere.radius;
  };
  return std::max(gap, 4.0 * resolution.at(std::max(reach(pair.a), reach(pair.b))));
}

MovingSolid ContactWorld::State::moving_solid(SolidIndex solid) const {
  const std::uint32_t slot = layout.slot_of[solid], root = objects[slot].root;
  const double stop = in_motion[root] ? stops[root] : 0.0;
  if (MechanismMover* mover = mechanism_of(slot))
    return {&layout.solids[solid],     X_BS[solid], &mover->path, objects[objects[slot].body].link, stop,
            travels.last_solid[solid], mover};
  return {&layout.solids[solid], layout.X_OS[solid], &paths[root], slot, stop, travels.last_solid[solid]};
}

MovingSolid ContactWorld::State::seen_from(std::uint32_t link, SolidIndex solid) const {
  MechanismMover& mover = *mechanism_of(layout.slot_of[solid]);
  MovingSolid seen = moving_solid(solid);
  seen.path = &mover.relative.seen_from(link, mover.path);
  return seen;
}

Impact ContactWorld::State::impact_of(FramePair& pair, double until) {
  const double now = travelled(pair.solids, pair.own);
  if (now <= pair.clear_until) {
    Impact clear;
    clear.geometry.n_AB_W = clear.geometry.p_A_W = clear.geometry.p_B_W = Vector3::Zero();
    clear.is_far = true;
    return clear;
  }
  query->set_pair(pair.solids);
  const auto [a, b] = pair.solids;
  Impact impact;
  if (pair.own == kNotOwn) {
    impact = find_impact(moving_solid(a), moving_solid(b), {pair.gap}, *query, pair.interest, until, false);
  } else {  // two links: the first stands still
    const std::uint32_t link = objects[body_of(a)].link;
    MovingSolid first = seen_from(link, a), second = seen_from(link, b);
    first.travel = 0.0, second.travel = travels.last_own[pair.own];
    impact = find_impact(first, second, {pair.gap}, *query, pair.interest, until, false);
  }
  if (query->judges_poses()) return impact;  // separations say nothing about what such a backend sees
  // The gap is far more than separations and sums round.
  const double room = impact.start_separation - pair.interest - pair.gap;
  if (impact.queries > 0 && room > 0.0 && now <= Travels::kMost)
    pair.clear_until = now * (1.0 - 0x1p-50) - last_travel(pair.solids, pair.own) * (1.0 + 0x1p-19) + room;
  return impact;
}

// Those that may be near at the start come first: where they stop a mover, all others need only be clear up
// to there.
void ContactWorld::State::find_pairs(FrameReport& report) {
  if (is_watch_due()) watch_pairs();
  pairs.clear();
  gather_unclear();
  for (const std::uint32_t root : movers) stop_bounds[root] = 1.0;
  examine(close, report);
  std::erase_if(deferred, [&](std::uint32_t i) { return is_clear_to_bounds(watched[i]); });
  examine(deferred, report);
  std::sort(pairs.begin(), pairs.end(),
            [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; });
}

/// The watched pairs that may not be clear: of what moves, or has moved since, and those that were not clear
/// before. Of many moving links those that are lively are fewer.
void ContactWorld::State::gather_unclear() {
  close.clear(), deferred.clear();
  if (++look == 0) {  // once in 2^32 looks: what was seen at the same count then has not been seen now
    std::fill(seen_at.begin(), seen_at.end(), 0u);
    look = 1;
  }
  seen_at.resize(std::max<std::size_t>(seen_at.size(), watched.size()), 0);
  const auto take = [&](std::uint32_t i) {
    if (seen_at[i] == look) return;
    seen_at[i] = look;
    if (!is_clear(watched[i])) (is_clear_before(watched[i]) ? deferred : close).push_back(i);
  };
  for (const std::uint32_t i : unclear) take(i);
  for (const std::vector<std::uint32_t>* roots : {&told, &told_before})
    for (const std::uint32_t root : *roots) {
      if (mechanism_of(root) != nullptr) continue;
      for_each_member(root, [&](std::uint32_t slot) {
        for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
          watched.for_each_of(solid, take);
      });
    }
  if (mechanisms.size() > 0) {
    if (needs_lively) choose_lively();
    for (const std::uint32_t i : lively) take(i);
  }
  unclear.clear();
  for (std::vector<std::uint32_t>* found : {&close, &deferred}) {
    unclear.insert(unclear.end(), found->begin(), found->end());
    std::sort(found->begin(), found->end(),
              [&](std::uint32_t x, std::uint32_t y) { return watched.solids(x) < watched.solids(y); });
  }
}

bool ContactWorld::State::is_checked(const SolidPair& pair) const {
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (objects[a].body == objects[b].body || (objects[a].is_static() && objects[b].is_static())) return false;
  return selection.is_on(objects, a, b) && !layout.is_exempt(pair);
}

FramePair ContactWorld::State::frame_pair(const SolidPair& pair) const {
  FramePair entry;
  entry.solids = pair;
  entry.rule = rules.find(objects, layout.slot_of[pair.a], layout.slot_of[pair.b]);
  entry.gap = gap_of(pair);
  entry.interest = std::max(2.0 * entry.gap, entry.rule.warn_distance);
  entry.own = own_index(pair);
  return entry;
}

/// How far a pair's path matters: up to where what is known so far stops its mover. Of two movers in motion
/// one may be stopped before the other.
double ContactWorld::State::matters_until(const SolidPair& pair) const {
  const std::uint32_t a = root_of(pair.a), b = root_of(pair.b);
  if (a != b && in_motion[a] && in_motion[b]) return 1.0;
  return stop_bounds[in_motion[a] ? a : b];
}

/// Finds the impacts of watched pairs and keeps those that are not known to stay apart. The nearest come
/// first, and each group of equally near ones bounds how far the paths of all after it matter.
void ContactWorld::State::examine(std::span<const std::uint32_t> watches, FrameReport& report) {
  constexpr std::size_t kAtOnce = 256;
  for (std::size_t first = 0; first < watches.size(); first += kAtOnce) {
    const std::size_t open = pairs.size();
    ahead.clear();
    for (const std::uint32_t i : watches.subspan(first, std::min(kAtOnce, watches.size() - first)))
      open_pair(i, report);
    query->look_ahead(ahead, from);
    order_by_separation(std::span(pairs).subspan(open));
    std::size_t kept = open, bounded = open;
    double nearest = -std::numeric_limits<double>::infinity();
    for (std::size_t k = open; k < pairs.size(); ++k) {
      if (pairs[k].start_separation > nearest) {
        bound_stops(std::span(pairs).first(kept).subspan(bounded));
        nearest = pairs[k].start_separation, bounded = kept;
      }
      if (is_of_interest(pairs[k], report)) pairs[kept++] = pairs[k];
    }
    pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(kept), pairs.end());
    bound_stops(std::span(pairs).subspan(bounded));
  }
}

/// Pairs of a mechanism's own links come last: they are seen from a link, and in other poses.
void ContactWorld::State::order_by_separation(std::span<FramePair> among) {
  for (FramePair& pair : among) {
    pair.start_separation = std::numeric_limits<double>::infinity();
    if (pair.own != kNotOwn) continue;
    PairGeometry geometry{};
    query->set_pair(pair.solids);
    query->separation(from[pair.solids.a], from[pair.solids.b], geometry);
    if (geometry.separation < pair.start_separation) pair.start_separation = geometry.separation;
  }
  std::sort(among.begin(), among.end(), [](const FramePair& a, const FramePair& b) {
    return a.start_separation != b.start_separation ? a.start_separation < b.start_separation
                                                    : a.solids < b.solids;
  });
}

void ContactWorld::State::open_pair(std::uint32_t watch, FrameReport& report) {
  const SolidPair pair{watched[watch].a, watched[watch].b};
  if (!is_checked(pair)) return;
  ++report.candidate_pairs;
  FramePair entry = frame_pair(pair);
  entry.watch = watch;
  // One whose two movers are in motion is looked at again when one of them is stopped.
  const std::uint32_t a = root_of(pair.a), b = root_of(pair.b);
  const bool both = a != b && in_motion[a] && in_motion[b];
  const double last = last_travel(pair, entry.own);
  const double standing = travelled(pair, entry.own) * (1.0 - 0x1p-50) - last * (1.0 + 0x1p-19);
  if (!both && is_apart_by_axis(watched[watch], entry, standing, last * matters_until(pair))) return;
  entry.clear_until = watched[watch].clear_until;
  if (entry.own == kNotOwn) ahead.push_back(pair);
  pairs.push_back(entry);
}

bool ContactWorld::State::is_of_interest(FramePair& pair, FrameReport& report) {
  pair.impact = impact_of(pair, matters_until(pair.solids));
  if (pair.impact.status == ImpactStatus::clear) pair.impact.lo = 1.0;  // what is beyond a stop is not gone
  watched[pair.watch].clear_until = pair.clear_until;
  if (pair.impact.queries > 0) watched[pair.watch].axis_W = pair.impact.geometry.n_AB_W;
  if (pair.impact.status == ImpactStatus::iteration_limit) ++report.iteration_limits;
  const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
  const bool both = a != b && in_motion[a] && in_motion[b];
  const bool starts_close = pair.impact.queries > 0 && pair.impact.start_separation <= pair.gap;
  return both || !pair.impact.is_far || starts_close || pair.impact.starts_overlapping;
}

void ContactWorld::State::execute() {
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && in_motion[mover->lead])
      mover->stand_at(stops[mover->lead]);
  for (const std::uint32_t slot : moved) {
    const std::uint32_t root = objects[slot].root;
    if (!in_motion[root]) continue;
    if (const MechanismMover* mover = mechanism_of(slot)) {
      const std::uint32_t body = objects[slot].body;
      const Pose& X_WL = mover->X_WL[objects[body].link];
      objects[slot].X_WO = body == slot ? X_WL : compose(X_WL, objects.poses_in_body()[slot]);
    } else {
      objects[slot].X_WO = paths[root].at(slot, stops[root]).X_WO;
    }
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      from[solid] = compose(objects[slot].X_WO, layout.X_OS[solid]), travels.has_vertices[solid] = 0;
  }
  for (const std::uint32_t root : movers)
    if (in_motion[root] && stops[root] < 1.0) take_back_travels(root);
}

}  // namespace touchstone
