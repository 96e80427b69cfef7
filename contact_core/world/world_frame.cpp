#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact_core/world/world_state.hpp"

// One frame: commands, paths, pairs, stops.

namespace touchstone {
namespace {

constexpr std::size_t kBlock = 256;

bool is_finite(const RigidPath& path) { return is_valid_pose(path.from()) && is_valid_pose(path.to()); }

/// How far a point of a body that turns by `turn` about `centre` strays from its chord: |p''| / 8, and never
/// more than the circle's diameter.
double bulge(const Vector3& turn_W, const Vector3& offset_W) {
  const double angle = norm(turn_W);
  if (angle == 0.0) return 0.0;
  const double radius = norm(cross(turn_W, offset_W)) / angle;
  return radius * std::min(2.0, angle * angle / 8.0) * (1.0 + 0x1p-40);
}

}  // namespace

void ContactWorld::State::take_selection() {
  queue.take(changes);
  for (const SelectionChange& change : changes) {
    selection.apply(change);
    record.push_back({frame, change});
  }
}

void ContactWorld::State::accept(std::span<const MotionCommand> commands) {
  for (std::uint32_t slot = 0; slot < objects.size(); ++slot) {
    in_motion[slot] = slides.may_slide[slot] = slides.translation_only[slot] = 0;
    stops[slot] = 1.0;
    if (objects[slot].alive && objects[slot].is_root(slot))
      paths[slot] = CarriedPath(RigidPath(objects[slot].X_WO), objects.poses_in_body());
  }
  for (const MotionCommand& command : commands) {
    if (!objects.may_move(command.object) || !is_finite(command.path)) {
      events.push_back(command_event(EventKind::refused, command.object));
      continue;
    }
    const std::uint32_t slot = command.object.slot;
    paths[slot] = CarriedPath(command.path, objects.poses_in_body());
    in_motion[slot] = !command.path.at_rest();
    objects[slot].commanded = command.path.to();
  }
}

void ContactWorld::State::lay_paths() {
  moved_before.swap(moved);
  moved.clear();
  for (std::uint32_t i = 0; i < layout.slots.size(); ++i) {
    const std::uint32_t slot = layout.slots[i], root = objects[slot].root;
    const bool is_moving = in_motion[root] && moves(slot);
    if (is_moving) moved.push_back(i);
    // One that moved in the frame before has a new resting path, one point.
    if (!is_moving && !std::binary_search(moved_before.begin(), moved_before.end(), i)) continue;
    const BodyState start = state_at(slot, 0.0), end = state_at(slot, 1.0);
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid) {
      from[solid] = compose(start.X_WO, layout.X_OS[solid]);
      to[solid] = compose(end.X_WO, layout.X_OS[solid]);
      bulges[solid] = bulge_of(solid, start);
    }
  }
}

/// Of the object's frame; centre and rates are its body's.
BodyState ContactWorld::State::state_at(std::uint32_t slot, double s) const {
  const MechanismMover* mover = mechanism_of(slot);
  if (mover == nullptr) return paths[objects[slot].root].at(slot, s);
  BodyState state = mover->path.at(objects[objects[slot].body].link, s);
  if (objects[slot].body != slot) state.X_WO = compose(state.X_WO, objects.poses_in_body()[slot]);
  return state;
}

double ContactWorld::State::bulge_of(SolidIndex solid, const BodyState& start) const {
  const Vector3& centre_S = layout.solids[solid].bounding_sphere().centre;
  const MechanismMover* mover = mechanism_of(layout.slot_of[solid]);
  if (mover != nullptr)
    return mover->path.bulge(objects[body_of(solid)].link, transform(X_BS[solid], centre_S));
  return bulge(start.angular_velocity_W, transform(from[solid], centre_S) - start.centre_W);
}

double ContactWorld::State::gap_of(const SolidPair& pair) const {
  const Resolution& resolution = narrowphase->capabilities().resolution;
  const auto reach = [&](SolidIndex i) {
    const Sphere& sphere = layout.solids[i].bounding_sphere();
    return from[i].p.cwiseAbs().maxCoeff() + norm(sphere.centre) + 2.0 * sphere.radius;
  };
  return std::max(gap, 4.0 * resolution.at(std::max(reach(pair.a), reach(pair.b))));
}

MovingSolid ContactWorld::State::moving_solid(SolidIndex solid) const {
  const std::uint32_t slot = layout.slot_of[solid], root = objects[slot].root;
  const double stop = in_motion[root] ? stops[root] : 0.0;
  if (const MechanismMover* mover = mechanism_of(slot))
    return {&layout.solids[solid], X_BS[solid], &mover->path, objects[objects[slot].body].link, stop};
  return {&layout.solids[solid], layout.X_OS[solid], &paths[root], slot, stop};
}

MovingSolid ContactWorld::State::seen_from(std::uint32_t link, SolidIndex solid) const {
  MechanismMover& mover = *mechanism_of(layout.slot_of[solid]);
  MovingSolid seen = moving_solid(solid);
  seen.path = &mover.relative.seen_from(link, mover.path);
  return seen;
}

Impact ContactWorld::State::impact_of(const FramePair& pair) {
  query->set_pair(pair.solids);
  const auto [a, b] = pair.solids;
  if (root_of(a) != root_of(b))
    return find_impact(moving_solid(a), moving_solid(b), {pair.gap}, *query, pair.interest);
  // Two links: the first stands still.
  const std::uint32_t link = objects[body_of(a)].link;
  return find_impact(seen_from(link, a), seen_from(link, b), {pair.gap}, *query, pair.interest);
}

void ContactWorld::State::find_pairs(FrameReport& report) {
  // What moves now and what came to rest: both have new paths.
  std::array<SolidPair, kBlock> block;
  moved_before.insert(moved_before.end(), moved.begin(), moved.end());
  std::sort(moved_before.begin(), moved_before.end());
  moved_before.erase(std::unique(moved_before.begin(), moved_before.end()), moved_before.end());
  broadphase->update_paths({from, to, bulges}, moved_before);
  pairs.clear();
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t count = broadphase->find_pairs(cursor, block);
    for (std::size_t i = 0; i < count; ++i) examine(block[i], report);
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
  return entry;
}

void ContactWorld::State::examine(const SolidPair& pair, FrameReport& report) {
  if (!is_checked(pair)) return;
  ++report.candidate_pairs;
  FramePair entry = frame_pair(pair);
  entry.impact = impact_of(entry);
  if (entry.impact.status == ImpactStatus::iteration_limit) ++report.iteration_limits;
  // With two movers in motion, one may be stopped before the other: such a pair is looked at again.
  const std::uint32_t a = root_of(pair.a), b = root_of(pair.b);
  const bool both = a != b && in_motion[a] && in_motion[b];
  if (both || !entry.impact.is_far) pairs.push_back(entry);
}

void ContactWorld::State::stop_movers(const FramePair& pair) {
  const double target = pair.rule.policy == ContactPolicy::hold ? 0.0 : pair.impact.lo;
  for (const SolidIndex solid : {pair.solids.a, pair.solids.b}) {
    const std::uint32_t root = root_of(solid);
    if (!in_motion[root] || stops[root] < target) continue;
    slides.note_stop(root, pair.rule, stops[root] == target && stops[root] < 1.0);
    if (stops[root] == target) continue;
    stops[root] = target;
    is_restopped[root] = 1;
  }
}

void ContactWorld::State::recheck(std::uint32_t root, std::vector<FramePair>& among) {
  for (FramePair& pair : among) {
    const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
    if (a != root && b != root) continue;
    const std::uint32_t other = a == root ? b : a;
    if (other != root && in_motion[other]) {
      pair.impact = impact_of(pair);
      pair.is_settled = false;
    } else if (pair.impact.lo >= stops[root]) {
      pair.impact.status = ImpactStatus::clear;  // the path now ends before
    }
  }
}

void ContactWorld::State::resolve_stops(std::vector<FramePair>& among) {
  // Each round takes the pairs with the least s, all of them (those already in contact at 0, say), stops
  // their movers, and only then looks again at what these could meet: no order of pairs shows. The cap is a
  // safeguard: then nothing moves, which is allowed.
  const std::size_t most = 16 + 8 * layout.slots.size();
  for (std::size_t round = 0; round < most; ++round) {
    const auto is_open = [](const FramePair& pair) { return pair.stops_movers() && !pair.is_settled; };
    double least = std::numeric_limits<double>::infinity();
    for (const FramePair& pair : among)
      if (is_open(pair)) least = std::min(least, pair.impact.lo);
    if (least == std::numeric_limits<double>::infinity()) return;
    for (FramePair& pair : among) {
      if (!is_open(pair) || pair.impact.lo != least) continue;
      pair.is_settled = true;
      if (!pair.has_blocked) pair.blocked_at = least;
      pair.has_blocked = true;
      stop_movers(pair);
    }
    for (const std::uint32_t slot : layout.slots) {
      if (is_restopped[slot]) recheck(slot, among);
      is_restopped[slot] = 0;
    }
  }
  std::fill(stops.begin(), stops.end(), 0.0);
}

void ContactWorld::State::execute() {
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && in_motion[mover->lead])
      mover->stand_at(stops[mover->lead]);
  for (std::uint32_t i = 0; i < layout.slots.size(); ++i) {
    const std::uint32_t slot = layout.slots[i], root = objects[slot].root;
    if (!in_motion[root] || !moves(slot)) continue;
    if (const MechanismMover* mover = mechanism_of(slot)) {
      const std::uint32_t body = objects[slot].body;
      const Pose& X_WL = mover->X_WL[objects[body].link];
      objects[slot].X_WO = body == slot ? X_WL : compose(X_WL, objects.poses_in_body()[slot]);
    } else {
      objects[slot].X_WO = paths[root].at(slot, stops[root]).X_WO;
    }
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      from[solid] = to[solid] = compose(objects[slot].X_WO, layout.X_OS[solid]);
  }
}

}  // namespace touchstone
