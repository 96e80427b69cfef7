#include "touchstone/contact_core/world/slide/shove.hpp"

#include <algorithm>
#include <utility>

#include "touchstone/contact_core/motion/slide.hpp"
#include "touchstone/contact_core/world/frame/contact_log.hpp"
#include "touchstone/contact_core/world/slide/leading_paths.hpp"

namespace touchstone {
namespace {

bool is_passive(const WorldModel& model, const Followers& followers, std::uint32_t root) {
  return !followers.is_commanded(root) && !model.objects[root].is_static() && !model.objects[root].is_link();
}

/// By what a mover's solid takes others along.
Followers::Lead lead_of(const WorldModel& model, const Followers& followers, SolidIndex solid) {
  const std::uint32_t slot = model.layout.slot_of[solid];
  const std::uint32_t leader = followers.leader_of(model.objects[slot].root);
  const MechanismMover* arm = model.arm_of(slot);
  return {leader, arm == nullptr ? 0 : arm->rigid_with[model.link_of(slot)]};
}

/// A mover's solid that takes others along: no link that stands.
bool may_lead(const WorldModel& model, SolidIndex solid) {
  return model.in_motion[model.root_of(solid)] && !model.objects[model.body_of(solid)].is_static();
}

/// Whether it goes on after it was stopped: see plan_arm_slide().
bool may_shove(const WorldModel& model, SolidIndex solid) {
  const MechanismMover* arm = model.arm_of(model.layout.slot_of[solid]);
  return may_lead(model, solid) && (arm == nullptr || arm->actual.size() <= kMostSlideJoints);
}

/// Takes along whom one leader alone claims. @returns whether there is any.
bool settle_claims(WorldModel& model, Movers& movers, Followers& followers) {
  return followers.settle([&](const Followers::Lead& lead, std::uint32_t root) {
    movers.add_follower(root);
    model.in_motion[root] = model.in_motion[lead.root];
    const Pose& X_WR = model.objects[root].X_WO;
    if (const MechanismMover* arm = model.mechanism_of(lead.root))
      model.rides.begin(root, lead.root, lead.link, arm->X_WL[lead.link], X_WR);
    go_along(model, lead.root, root);
  });
}

bool carries(const WorldModel& model, const SolidPair& pair) {
  const EffectiveRule rule =
      model.rules.find(model.objects, model.layout.slot_of[pair.a], model.layout.slot_of[pair.b]);
  return rule.passive == Passive::carried && rule.policy != ContactPolicy::hold &&
         rule.policy != ContactPolicy::cue;
}

/// Claims whichever of the two in contact is the other one's load.
void claim_load(const WorldModel& model, const SolidPair& pair, Followers& followers) {
  for (const auto& [mover, other] : {std::pair{pair.a, pair.b}, std::pair{pair.b, pair.a}}) {
    if (!may_lead(model, mover) || !is_passive(model, followers, model.root_of(other))) continue;
    if (model.is_checked(pair) && carries(model, pair))
      followers.claim(lead_of(model, followers, mover), model.root_of(other));
  }
}

/// The same of all that touches the root and that no frame has looked at since set-up.
void claim_fresh_loads(const WorldModel& model, const StandingContacts& contacts, std::uint32_t root,
                       Followers& followers) {
  model.for_each_solid(root, [&](SolidIndex solid) {
    contacts.watched.for_each_of(solid, [&](std::uint32_t index) {
      const WatchedPair& watch = contacts.watched[index];
      const SolidPair pair{watch.a, watch.b};
      if (model.is_clear(watch) || is_among(contacts.known, pair) || !model.is_checked(pair)) return;
      const SolidIndex other = solid == pair.a ? pair.b : pair.a;
      if (!is_passive(model, followers, model.root_of(other)) || !carries(model, pair)) return;
      if (touches(model, contacts.query, model.frame_pair(pair))) claim_load(model, pair, followers);
    });
  });
}

}  // namespace

void go_along(WorldModel& model, std::uint32_t leader, std::uint32_t root) {
  const Pose& X_WR = model.objects[root].X_WO;
  const bool rides = model.rides.find(root) != nullptr;  // on the link's path
  const RigidPath path = rides ? RigidPath(X_WR) : path_along(model.paths[leader].carrier(), X_WR);
  model.paths[root] = CarriedPath(path, model.objects.poses_in_body());
  model.stops[root] = 1.0;
}

void take_loads(WorldModel& model, const StandingContacts& contacts, Movers& movers, Followers& followers) {
  followers.begin(movers.commanded_before, movers.commanded);
  if (!model.rules.moves_passive() || movers.roots.empty()) return;
  followers.nothing_is_disputed();
  std::size_t taken = 0;
  bool any = true;
  for (bool is_first = true; any; is_first = false) {
    for (const ContactState& contact : contacts.known) claim_load(model, contact.solids, followers);
    if (contacts.is_fresh) {
      const auto newest =
          is_first ? std::span<const std::uint32_t>(movers.roots) : followers.all().subspan(taken);
      for (const std::uint32_t root : newest) claim_fresh_loads(model, contacts, root, followers);
    }
    taken = followers.all().size();
    any = settle_claims(model, movers, followers);
  }
}

bool take_shoved(WorldModel& model, std::span<const FramePair> among, Movers& movers, Followers& followers,
                 ExecutedParts& parts) {
  if (!model.rules.moves_passive()) return false;
  // No leader is known to be blocked yet.
  for (const std::uint32_t root : movers.roots) followers.set_blocked(root, false);
  // each() visits every mover that a pair stopped, with the solid that stopped it.
  const auto stopped = [&](const FramePair& pair, SolidIndex solid) {
    const std::uint32_t root = model.root_of(solid);
    const double stop = model.stops[root];
    return model.in_motion[root] && stop < 1.0 && pair.is_settled && pair.impact.lo == stop;
  };
  const auto each = [&](const auto& act) {
    for (const FramePair& pair : among) {
      if (stopped(pair, pair.solids.a)) act(pair, pair.solids.a, pair.solids.b);
      if (stopped(pair, pair.solids.b)) act(pair, pair.solids.b, pair.solids.a);
    }
  };
  // A leader is blocked by anything that does not go along.
  each([&](const FramePair& pair, SolidIndex mover, SolidIndex solid) {
    const std::uint32_t other = model.root_of(solid);
    const bool goes = pair.rule.passive != Passive::stays && !pair.holds() && may_shove(model, mover) &&
                      is_passive(model, followers, other) && !followers.is_disputed(other);
    if (!goes) followers.set_blocked(followers.leader_of(model.root_of(mover)), true);
  });
  // Leaders that are not blocked claim what stopped them.
  each([&](const FramePair&, SolidIndex mover, SolidIndex other) {
    const Followers::Lead lead = lead_of(model, followers, mover);
    if (!followers.is_blocked(lead.root)) followers.claim(lead, model.root_of(other));
  });
  // New followers start at rest, and their part is recorded.
  const std::size_t before = followers.all().size();
  const bool any = settle_claims(model, movers, followers);
  for (const std::uint32_t root : followers.all().subspan(before)) {
    rest(model, root);
    parts.add(model.objects.handle(root), 0, model.paths[root], 1.0);
  }
  return any;
}

}  // namespace touchstone
