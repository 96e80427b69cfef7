#include <algorithm>

#include "touchstone/contact_core/world/slide/leading_paths.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// Objects without a command of their own that go along with a rigid mover: what is carried from the frame's
// start, what is shoved from where it stopped the mover. Leader and followers take the same rigid motion part
// by part, checked against everything, each other too, and are stopped together.

namespace touchstone {

bool ContactWorld::State::is_passive(std::uint32_t root) const {
  return !followers.is_told(root) && !objects[root].is_static() && !objects[root].is_link();
}

void ContactWorld::State::go_along(std::uint32_t leader, std::uint32_t root) {
  paths[root] = CarriedPath(path_along(paths[leader].carrier(), objects[root].X_WO), objects.poses_in_body());
  stops[root] = 1.0;
}

/// Takes along whom one leader alone claims. @returns whether there is any.
bool ContactWorld::State::settle_claims() {
  return followers.settle([&](std::uint32_t leader, std::uint32_t root) {
    told.push_back(root);
    movers.insert(std::lower_bound(movers.begin(), movers.end(), root), root);
    in_motion[root] = in_motion[leader];
    go_along(leader, root);
  });
}

/// Loads that were in contact with their carrier as the frame began, and theirs.
void ContactWorld::State::take_loads() {
  followers.begin(told_before, told);
  if (!rules.moves_passive() || movers.empty()) return;
  followers.nothing_is_disputed();
  do {
    for (const ContactState& contact : contacts) {
      const std::uint32_t a = root_of(contact.solids.a), b = root_of(contact.solids.b);
      for (const auto& [mover, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (!in_motion[mover] || objects[mover].is_link() || !is_passive(other)) continue;
        if (!is_checked(contact.solids)) continue;
        const EffectiveRule rule =
            rules.find(objects, layout.slot_of[contact.solids.a], layout.slot_of[contact.solids.b]);
        const bool may_go = rule.policy != ContactPolicy::hold && rule.policy != ContactPolicy::cue;
        if (may_go && rule.passive == Passive::carried) followers.claim(followers.leader_of(mover), other);
      }
    }
  } while (settle_claims());
}

/// Once a part is executed: takes along what stopped a leader, where nothing else did.
/// @returns whether there is any.
bool ContactWorld::State::shove(std::span<const FramePair> among) {
  if (!rules.moves_passive()) return false;
  for (const std::uint32_t root : movers) followers.set_blocked(root, false);
  const auto stopped = [&](const FramePair& pair, std::uint32_t root) {
    return in_motion[root] && stops[root] < 1.0 && pair.is_settled && pair.impact.lo == stops[root];
  };
  const auto each = [&](const auto& act) {
    for (const FramePair& pair : among) {
      const std::uint32_t a = root_of(pair.solids.a), b = root_of(pair.solids.b);
      if (stopped(pair, a)) act(pair, a, b);
      if (stopped(pair, b)) act(pair, b, a);
    }
  };
  each([&](const FramePair& pair, std::uint32_t mover, std::uint32_t other) {
    const bool goes = pair.rule.passive != Passive::stays && !pair.holds() && is_passive(other) &&
                      !followers.is_disputed(other) && !objects[mover].is_link();
    if (!goes) followers.set_blocked(followers.leader_of(mover), true);
  });
  each([&](const FramePair&, std::uint32_t mover, std::uint32_t other) {
    const std::uint32_t leader = followers.leader_of(mover);
    if (!followers.is_blocked(leader)) followers.claim(leader, other);
  });
  const std::size_t before = followers.all().size();
  const bool any = settle_claims();
  for (const std::uint32_t root : followers.all().subspan(before)) {
    rest(root);
    parts.add(objects.handle(root), 0, paths[root], 1.0);  // it stood until now
  }
  return any;
}

}  // namespace touchstone
