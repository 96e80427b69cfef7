#include "touchstone/contact_core/world/slide/shove.hpp"

#include <algorithm>

#include "touchstone/contact_core/world/slide/leading_paths.hpp"

namespace touchstone {
namespace {

bool is_passive(const WorldModel& model, const Followers& followers, std::uint32_t root) {
  return !followers.is_told(root) && !model.objects[root].is_static() && !model.objects[root].is_link();
}

/// Takes along whom one leader alone claims. @returns whether there is any.
bool settle_claims(WorldModel& model, Movers& movers, Followers& followers) {
  return followers.settle([&](std::uint32_t leader, std::uint32_t root) {
    movers.add_follower(root);
    model.in_motion[root] = model.in_motion[leader];
    go_along(model, leader, root);
  });
}

}  // namespace

void go_along(WorldModel& model, std::uint32_t leader, std::uint32_t root) {
  model.paths[root] = CarriedPath(path_along(model.paths[leader].carrier(), model.objects[root].X_WO),
                                  model.objects.poses_in_body());
  model.stops[root] = 1.0;
}

void take_loads(WorldModel& model, std::span<const ContactState> contacts, Movers& movers,
                Followers& followers) {
  followers.begin(movers.told_before, movers.told);
  if (!model.rules.moves_passive() || movers.roots.empty()) return;
  followers.nothing_is_disputed();
  do {
    for (const ContactState& contact : contacts) {
      const std::uint32_t a = model.root_of(contact.solids.a), b = model.root_of(contact.solids.b);
      for (const auto& [mover, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (!model.in_motion[mover] || model.objects[mover].is_link()) continue;
        if (!is_passive(model, followers, other) || !model.is_checked(contact.solids)) continue;
        const EffectiveRule rule = model.rules.find(model.objects, model.layout.slot_of[contact.solids.a],
                                                    model.layout.slot_of[contact.solids.b]);
        const bool may_go = rule.policy != ContactPolicy::hold && rule.policy != ContactPolicy::cue;
        if (may_go && rule.passive == Passive::carried) followers.claim(followers.leader_of(mover), other);
      }
    }
  } while (settle_claims(model, movers, followers));
}

bool take_shoved(WorldModel& model, std::span<const FramePair> among, Movers& movers, Followers& followers,
                 ExecutedParts& parts) {
  if (!model.rules.moves_passive()) return false;
  for (const std::uint32_t root : movers.roots) followers.set_blocked(root, false);
  const auto stopped = [&](const FramePair& pair, std::uint32_t root) {
    const double stop = model.stops[root];
    return model.in_motion[root] && stop < 1.0 && pair.is_settled && pair.impact.lo == stop;
  };
  const auto each = [&](const auto& act) {
    for (const FramePair& pair : among) {
      const std::uint32_t a = model.root_of(pair.solids.a), b = model.root_of(pair.solids.b);
      if (stopped(pair, a)) act(pair, a, b);
      if (stopped(pair, b)) act(pair, b, a);
    }
  };
  each([&](const FramePair& pair, std::uint32_t mover, std::uint32_t other) {
    const bool goes = pair.rule.passive != Passive::stays && !pair.holds() &&
                      is_passive(model, followers, other) && !followers.is_disputed(other) &&
                      !model.objects[mover].is_link();
    if (!goes) followers.set_blocked(followers.leader_of(mover), true);
  });
  each([&](const FramePair&, std::uint32_t mover, std::uint32_t other) {
    const std::uint32_t leader = followers.leader_of(mover);
    if (!followers.is_blocked(leader)) followers.claim(leader, other);
  });
  const std::size_t before = followers.all().size();
  const bool any = settle_claims(model, movers, followers);
  for (const std::uint32_t root : followers.all().subspan(before)) {
    rest(model, root);
    parts.add(model.objects.handle(root), 0, model.paths[root], 1.0);
  }
  return any;
}

}  // namespace touchstone
