#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "touchstone/contact_core/world/world_state.hpp"

// One frame: commands, paths, and which pairs may not be clear on them. When these meet is found in
// world_examine.cpp; stops are in world_stops.cpp, what is reported in world_events.cpp.

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
  ++travels.clearings;
  told_before.swap(told);
  told.clear();
  movers.clear();
  for (const std::uint32_t slot : told_before) {
    StopPermits& permits = slides.permits;
    for (std::vector<std::uint8_t>* flags :
         {&in_motion, &is_short, &is_held, &is_restopped, &permits.may_slide, &permits.may_pivot,
          &permits.translation_only})
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

/// The watched pairs that may not be clear: of what moves, or has moved since, and those that were not clear
/// before. Of many moving links those that are lively are fewer. Pairs that are off are kept, unsorted: when
/// they are switched on they may have come near.
void ContactWorld::State::gather_unclear() {
  constexpr std::size_t kRootsAtOnce = 16;
  looked_at.clear();
  for (const std::vector<std::uint32_t>* roots : {&told, &told_before})
    for (const std::uint32_t root : *roots) {
      if (is_looked_at[root] || mechanism_of(root) != nullptr) continue;
      is_looked_at[root] = 1;
      looked_at.push_back(root);
    }
  if (mechanisms.size() > 0 && needs_lively) choose_lively();
  gathered.resize(std::max(gathered.size(), 4 * std::size_t{watched.size()}));
  off.resize(std::max(off.size(), gathered.size()));
  std::atomic<std::size_t> count{0}, off_count{0};
  const auto take = [&](std::uint32_t i) {
    if (is_clear(watched[i])) return;
    const SolidPair pair = watched.solids(i);
    if (is_checked(pair))
      gathered[count.fetch_add(1, std::memory_order_relaxed)] = {pair, i};
    else
      off[off_count.fetch_add(1, std::memory_order_relaxed)] = i;
  };
  // A pair of two roots that are looked at comes from its a.
  lanes.for_each(looked_at.size(), kRootsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    for_each_solid(looked_at[i], [&](SolidIndex solid) {
      watched.for_each_of(solid, [&](std::uint32_t index) {
        if (watched[index].a == solid || !is_looked_at[root_of(watched[index].a)]) take(index);
      });
    });
  });
  is_taken.resize(std::max(is_taken.size(), std::size_t{watched.size()}), 0);
  const auto take_once = [&](std::uint32_t i) {
    if (is_taken[i] || is_looked_at[root_of(watched[i].a)] || is_looked_at[root_of(watched[i].b)]) return;
    is_taken[i] = 1;
    take(i);
  };
  const std::span<const std::uint32_t> of_links =
      mechanisms.size() > 0 ? std::span<const std::uint32_t>(lively) : std::span<const std::uint32_t>();
  for (const std::span<const std::uint32_t> list : {std::span<const std::uint32_t>(unclear), of_links})
    std::for_each(list.begin(), list.end(), take_once);
  for (const std::span<const std::uint32_t> list : {std::span<const std::uint32_t>(unclear), of_links})
    for (const std::uint32_t i : list) is_taken[i] = 0;
  for (const std::uint32_t root : looked_at) is_looked_at[root] = 0;
  sort_gathered(count);
  unclear.assign(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off_count));
  close.clear(), deferred.clear();
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = gathered[k].watch;
    unclear.push_back(i);
    (is_clear_before(watched[i]) ? deferred : close).push_back(i);
  }
}

void ContactWorld::State::sort_gathered(std::size_t count) {
  std::sort(gathered.begin(), gathered.begin() + static_cast<std::ptrdiff_t>(count));
}

void ContactWorld::State::execute() {
  constexpr std::size_t kObjectsAtOnce = 64;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && in_motion[mover->lead])
      mover->stand_at(stops[mover->lead]);
  lanes.for_each(moved.size(), kObjectsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    const std::uint32_t slot = moved[i], root = objects[slot].root;
    if (!in_motion[root]) return;
    if (const MechanismMover* mover = mechanism_of(slot)) {
      const std::uint32_t body = objects[slot].body;
      const Pose& X_WL = mover->X_WL[objects[body].link];
      objects[slot].X_WO = body == slot ? X_WL : compose(X_WL, objects.poses_in_body()[slot]);
    } else {
      objects[slot].X_WO = paths[root].at(slot, stops[root]).X_WO;
    }
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      from[solid] = compose(objects[slot].X_WO, layout.X_OS[solid]), travels.has_vertices[solid] = 0;
  });
  for (const std::uint32_t slot : moved)
    if (in_motion[objects[slot].root]) note_place(slot);
  for (const std::uint32_t root : movers)
    if (in_motion[root] && stops[root] < 1.0) take_back_travels(root);
}

}  // namespace touchstone
