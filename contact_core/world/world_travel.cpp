#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/world/world_state.hpp"

// Which pairs have to be looked at: those that could have come near since they were looked at last. The
// broadphase is asked now and then, for where everything can come until it is asked again.

namespace touchstone {
namespace {

/// Solids may go so many times as far as on the path at hand, and so much of their radius, before the
/// broadphase is asked again.
constexpr double kReserveFrames = 8.0;
constexpr double kReserveRadius = 0.125;
/// The same of the lively ones of the watched pairs.
constexpr double kLivelyFrames = 1.0;
constexpr double kLivelyRadius = 0x1p-6;
/// And so many times as far as slides ask.
constexpr double kReserveNeeds = 1.5;
/// Of more objects than one in so many the pairs are found together with all others.
constexpr std::size_t kWatchAll = 4;
/// Rounding of bounds.
constexpr double kUp = 1.0 + 0x1p-20;

}  // namespace

void ContactWorld::State::lay_travels(std::uint32_t root) {
  const std::pair<std::uint32_t, std::uint32_t> first{root, 0};
  for (auto member = std::lower_bound(members.begin(), members.end(), first);
       member != members.end() && member->first == root; ++member) {
    const std::uint32_t slot = member->second;
    if (!moves(slot)) continue;
    moved.push_back(slot);
    const BodyState start = state_at(slot, 0.0);
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      lay_travel(solid, start);
  }
  if (mechanism_of(root) != nullptr) lay_own_travels(root);
}

void ContactWorld::State::lay_travel(SolidIndex solid, const BodyState& start) {
  const Sphere& sphere = layout.solids[solid].bounding_sphere();
  if (const MechanismMover* mover = mechanism_of(layout.slot_of[solid])) {
    travels.last_solid[solid] = has_planned(*mover) ? travels.planned_solid[solid] : travel_on(*mover, solid);
  } else {
    const double arm = norm(transform(from[solid], sphere.centre) - start.centre_W) + sphere.radius;
    travels.last_solid[solid] = (norm(start.velocity_W) + norm(start.angular_velocity_W) * arm) * kUp;
  }
  travels.of_solid[solid] = Travels::sum(travels.of_solid[solid], travels.last_solid[solid]);
  if (!(travels.of_solid[solid] <= travels.solid_limit[solid])) note_due(layout.slot_of[solid]);
  is_overflown = is_overflown || !(travels.of_solid[solid] <= Travels::kMost);
  needs_lively = needs_lively || !(travels.of_solid[solid] <= travels.lively_solid[solid]);
}

/// Sums that overflowed know nothing any more: counting begins anew.
void ContactWorld::State::restart_travels() {
  if (!is_overflown) return;
  is_overflown = false;
  std::fill(travels.of_solid.begin(), travels.of_solid.end(), 0.0);
  std::fill(travels.of_own.begin(), travels.of_own.end(), 0.0);
  watched.clear();
  needs_watch = true;
}

void ContactWorld::State::lay_own_travels(std::uint32_t root) {
  const MechanismMover& mover = *mechanism_of(root);
  const auto links = static_cast<std::uint32_t>(mover.X_WL.size());
  if (has_planned(mover)) {
    const auto planned = travels.planned_own.begin() + mover.first_own;
    std::copy(planned, planned + links * links, travels.last_own.begin() + mover.first_own);
  } else {
    measure_own_travels(mover, travels.last_own);
  }
  for (std::uint32_t own = mover.first_own; own < mover.first_own + links * links; ++own)
    travels.of_own[own] = Travels::sum(travels.of_own[own], travels.last_own[own]),
    needs_lively = needs_lively || !(travels.of_own[own] <= travels.lively_own[own]),
    is_overflown = is_overflown || !(travels.of_own[own] <= Travels::kMost);
}

/// What a mover does not go: rates are bounded, so that up to s it goes s times as far at most. A sum less
/// its last term is not below the sum before: see Travels::sum().
void ContactWorld::State::take_back_travels(std::uint32_t root) {
  const auto shorten = [&](double& sum, double& last) {
    const double gone = last * stops[root];
    sum = (sum - last) + gone;
    last = gone;
  };
  const std::pair<std::uint32_t, std::uint32_t> first{root, 0};
  for (auto member = std::lower_bound(members.begin(), members.end(), first);
       member != members.end() && member->first == root; ++member) {
    const std::uint32_t slot = member->second;
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      shorten(travels.of_solid[solid], travels.last_solid[solid]);
  }
  const MechanismMover* mover = mechanism_of(root);
  if (mover == nullptr) return;
  const std::size_t links = mover->X_WL.size();
  for (std::size_t own = mover->first_own; own < mover->first_own + links * links; ++own)
    shorten(travels.of_own[own], travels.last_own[own]);
}

/// Clear where it stood before the path that is laid.
bool ContactWorld::State::is_clear_before(const WatchedPair& watch) const {
  const SolidPair pair{watch.a, watch.b};
  return travelled(pair, watch.own) - last_travel(pair, watch.own) <= watch.clear_until;
}

/// Clear as far as stop_bounds let its movers go.
bool ContactWorld::State::is_clear_to_bounds(const WatchedPair& watch) const {
  const double a = stop_bounds[root_of(watch.a)], b = stop_bounds[root_of(watch.b)];
  const double gone = watch.own != kNotOwn
                          ? a * travels.last_own[watch.own]
                          : a * travels.last_solid[watch.a] + b * travels.last_solid[watch.b];
  const SolidPair pair{watch.a, watch.b};
  return (travelled(pair, watch.own) - last_travel(pair, watch.own)) + gone <= watch.clear_until;
}

void ContactWorld::State::note_due(std::uint32_t slot) {
  if (is_noted_due[slot] != 0) return;
  is_noted_due[slot] = 1;
  due.push_back(slot);
}

/// Of all objects, or of those only that went beyond their limits or are new here.
void ContactWorld::State::watch_pairs() {
  std::erase_if(due, [&](std::uint32_t slot) {
    if (layout.is_alive(slot)) return false;
    is_noted_due[slot] = 0;
    return true;
  });
  if (needs_watch || kWatchAll * due.size() > layout.slots() || !watch_due()) watch_all();
  for (const std::uint32_t slot : due) is_noted_due[slot] = 0;
  due.clear();
  needs_watch = false;
  needs_lively = true;
}

/// Where the object's solids may be until its pairs are found anew.
void ContactWorld::State::set_region(std::uint32_t slot) {
  const bool is_static = layout.is_static[slot] != 0;
  for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid) {
    const double radius = layout.solids[solid].bounding_sphere().radius;
    const double usual = kReserveFrames * travels.last_solid[solid] + kReserveRadius * radius;
    const double reserve = is_static ? 0.0 : std::max(usual, kReserveNeeds * travels.needed[solid]);
    to[solid] = from[solid];
    bulges[solid] = (reserve + reaches[slot] + contact_reach(solid, reserve)) * kUp;
    // The path at hand is counted already, but not gone yet.
    travels.solid_limit[solid] = travels.of_solid[solid] - travels.last_solid[solid] * kUp + reserve;
  }
}

bool ContactWorld::State::may_be_watched(const SolidPair& pair) const {
  const std::uint32_t a = layout.slot_of[pair.a], b = layout.slot_of[pair.b];
  if (!layout.is_alive(a) || !layout.is_alive(b)) return false;
  if (objects[a].body == objects[b].body || (objects[a].is_static() && objects[b].is_static())) return false;
  return !layout.is_exempt(pair);
}

/// @returns false where the broadphase knows all pairs only.
bool ContactWorld::State::watch_due() {
  std::sort(due.begin(), due.end());
  for (const std::uint32_t slot : due) set_region(slot);
  broadphase->update_paths({to, to, bulges}, due);
  for (const std::uint32_t slot : due)
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      if (!watch_partners(solid)) return false;
  return true;
}

/// What is known of pairs that are watched already stays so.
bool ContactWorld::State::watch_partners(SolidIndex solid) {
  partners.clear(), known_partners.clear();
  if (!broadphase->find_partners(solid, partners)) return false;
  watched.for_each_of(solid, [&](std::uint32_t index) {
    const SolidPair pair = watched.solids(index);
    known_partners.emplace_back(pair.a == solid ? pair.b : pair.a, index);
  });
  std::sort(partners.begin(), partners.end());
  std::sort(known_partners.begin(), known_partners.end());
  auto before = known_partners.begin();
  for (const SolidIndex other : partners) {
    for (; before != known_partners.end() && before->first < other; ++before) watched.remove(before->second);
    if (before != known_partners.end() && before->first == other) {
      ++before;
      continue;
    }
    const SolidPair pair{std::min(solid, other), std::max(solid, other)};
    if (may_be_watched(pair)) unclear.push_back(watched.add({pair.a, pair.b, own_index(pair), kNotKnown}));
  }
  for (; before != known_partners.end(); ++before) watched.remove(before->second);
  return true;
}

void ContactWorld::State::watch_all() {
  movable.clear();
  for (std::uint32_t slot = 0; slot < layout.slots(); ++slot) {
    if (!layout.is_alive(slot)) continue;
    if (layout.is_static[slot] != 0 && is_noted_due[slot] == 0 && reaches[slot] == 0.0) continue;
    set_region(slot);
    movable.push_back(slot);
  }
  broadphase->update_paths({to, to, bulges}, movable);
  std::swap(watched_before, watched);
  watched.clear();
  watched.set_solids(layout.solids.size());
  unclear.clear();
  PairCursor cursor;
  std::array<SolidPair, 256> block;
  while (!cursor.done) {
    const std::size_t count = broadphase->find_pairs(cursor, block);
    for (const SolidPair& pair : std::span(block).first(count)) {
      if (!may_be_watched(pair)) continue;
      WatchedPair watch{pair.a, pair.b, own_index(pair), kNotKnown};
      const std::uint32_t before = watched_before.find(pair);
      if (before != PairWatch::kNone)
        watch.clear_until = watched_before[before].clear_until, watch.axis_W = watched_before[before].axis_W;
      unclear.push_back(watched.add(watch));
    }
  }
}

/// Most watched pairs stay out of reach for many frames: those that may not are found now and then.
void ContactWorld::State::choose_lively() {
  for (SolidIndex solid = 0; solid < layout.solids.size(); ++solid)
    if (layout.is_static[layout.slot_of[solid]] == 0)
      travels.lively_solid[solid] = travels.of_solid[solid] + kLivelyFrames * travels.last_solid[solid] +
                                    2.0 * travels.planned_solid[solid] +
                                    kLivelyRadius * layout.solids[solid].bounding_sphere().radius;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i) {
    const MechanismMover* mover = mechanisms.at(i);
    if (mover == nullptr) continue;
    const std::size_t links = mover->X_WL.size();
    for (std::size_t k = 0; k < links * links; ++k) {
      const std::size_t own = mover->first_own + k;
      travels.lively_own[own] = travels.of_own[own] + kLivelyFrames * travels.last_own[own] +
                                2.0 * travels.planned_own[own] +
                                kLivelyRadius * mover->radius_of_link[k % links];
    }
  }
  lively.clear();
  for (std::uint32_t i = 0; i < watched.size(); ++i) {
    const WatchedPair& watch = watched[i];
    const double limit = watch.own != kNotOwn ? travels.lively_own[watch.own]
                                              : travels.lively_solid[watch.a] + travels.lively_solid[watch.b];
    if (!(limit <= watch.clear_until)) lively.push_back(i);
  }
  std::sort(lively.begin(), lively.end(),
            [&](std::uint32_t x, std::uint32_t y) { return watched.solids(x) < watched.solids(y); });
  needs_lively = false;
}

}  // namespace touchstone
