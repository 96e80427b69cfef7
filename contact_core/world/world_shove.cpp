#include <algorithm>
#include <array>
#include <numbers>

#include "touchstone/contact_core/world/world_state.hpp"

// Objects without a command of their own that go along with a rigid mover: what is carried from the frame's
// start, what is shoved from where it stopped the mover. Leader and followers take the same rigid motion part
// by part, checked against everything, each other too, and are stopped together.

namespace touchstone {

std::string_view to_string(Passive passive) {
  constexpr std::array<std::string_view, 3> kNames{"stays", "shoved", "carried"};
  return kNames[static_cast<std::size_t>(passive)];
}

bool ContactWorld::State::is_passive(std::uint32_t root) const {
  return !shoves.is_told[root] && !objects[root].is_static() && !objects[root].is_link();
}

/// The motion of `leader`, from where another root stands.
CarriedPath ContactWorld::State::path_along(std::uint32_t leader, std::uint32_t root) const {
  const Pose& X_WO = objects[root].X_WO;
  const BodyState way = paths[leader].carrier().at(0, 0.0);
  if (paths[leader].carrier().at_rest()) return CarriedPath(RigidPath(X_WO), objects.poses_in_body());
  return CarriedPath(
      RigidPath::by(X_WO, way.velocity_W, way.angular_velocity_W, transform(inverse(X_WO), way.centre_W)),
      objects.poses_in_body());
}

void ContactWorld::State::take_along(std::uint32_t leader, std::uint32_t root) {
  shoves.leader_of[root] = leader;
  shoves.followers.push_back(root);
  shoves.is_told[root] = 1;
  told.push_back(root);
  movers.insert(std::lower_bound(movers.begin(), movers.end(), root), root);
  paths[root] = path_along(leader, root);
  in_motion[root] = in_motion[leader];
  stops[root] = 1.0;
}

/// Whoever goes along with whom, once for each pair of the two; the one that two leaders want stays.
void ContactWorld::State::claim(std::uint32_t leader, std::uint32_t root) {
  std::uint32_t& wanted = shoves.claim_of[root];
  if (wanted == SlideState::kNone) shoves.claimed.push_back(root);
  const bool is_disputed = wanted != SlideState::kNone && wanted != leader;
  wanted = is_disputed || shoves.is_disputed[root] ? root : leader;
  shoves.is_disputed[root] = shoves.is_disputed[root] || is_disputed;
}

/// @returns whether any goes along that did not before.
bool ContactWorld::State::settle_claims() {
  std::sort(shoves.claimed.begin(), shoves.claimed.end());
  bool any = false;
  for (const std::uint32_t root : shoves.claimed) {
    const std::uint32_t leader = shoves.claim_of[root];
    shoves.claim_of[root] = SlideState::kNone;
    if (shoves.is_disputed[root]) continue;
    take_along(leader, root);
    any = true;
  }
  shoves.claimed.clear();
  return any;
}

/// Loads that were in contact with their carrier as the frame began, and theirs.
void ContactWorld::State::take_loads() {
  for (const std::uint32_t root : shoves.followers) shoves.leader_of[root] = SlideState::kNone;
  shoves.followers.clear();
  for (const std::uint32_t slot : told_before) shoves.is_told[slot] = 0;
  for (const std::uint32_t slot : told) shoves.is_told[slot] = 1;
  if (!rules.moves_passive() || movers.empty()) return;
  std::fill(shoves.is_disputed.begin(), shoves.is_disputed.end(), std::uint8_t{0});
  do {
    for (const ContactState& contact : contacts) {
      const std::uint32_t a = root_of(contact.solids.a), b = root_of(contact.solids.b);
      for (const auto& [mover, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (!in_motion[mover] || objects[mover].is_link() || !is_passive(other)) continue;
        if (!is_checked(contact.solids)) continue;
        const EffectiveRule rule =
            rules.find(objects, layout.slot_of[contact.solids.a], layout.slot_of[contact.solids.b]);
        const bool may_go = rule.policy != ContactPolicy::hold && rule.policy != ContactPolicy::cue;
        if (may_go && rule.passive == Passive::carried) claim(leader_of(mover), other);
      }
    }
  } while (settle_claims());
}

/// Once a part is executed: takes along what stopped a leader, where nothing else did.
/// @returns whether there is any.
bool ContactWorld::State::shove(std::span<const FramePair> among) {
  if (!rules.moves_passive()) return false;
  for (const std::uint32_t root : movers) shoves.is_blocked[root] = 0;
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
                      !shoves.is_disputed[other] && !objects[mover].is_link();
    if (!goes) shoves.is_blocked[leader_of(mover)] = 1;
  });
  each([&](const FramePair&, std::uint32_t mover, std::uint32_t other) {
    if (!shoves.is_blocked[leader_of(mover)]) claim(leader_of(mover), other);
  });
  const std::size_t before = shoves.followers.size();
  const bool any = settle_claims();
  for (std::size_t i = before; i < shoves.followers.size(); ++i) {
    const std::uint32_t root = shoves.followers[i];
    // It stood until now.
    slides.parts.push_back({root, 0, CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body()), 1.0,
                            static_cast<std::uint32_t>(slides.joints.size()), objects.handle(root)});
    rest(root);
  }
  return any;
}

/// Entries for those that go along with a slider, by root as all; more than once does no harm.
void ContactWorld::State::add_follower_sliders() {
  for (const std::uint32_t root : shoves.followers) {
    if (slides.slider_of[root] != SlideState::kNone || slides.find(shoves.leader_of[root]) == nullptr)
      continue;
    slides.slider_of[root] = static_cast<std::uint32_t>(slides.sliders.size());
    Slider follower{};
    follower.root = root;
    follower.goal = objects[root].X_WO;
    follower.done = follower.follows = true;
    slides.sliders.push_back(follower);
  }
  std::sort(slides.sliders.begin(), slides.sliders.end(),
            [](const Slider& a, const Slider& b) { return a.root < b.root; });
  for (std::uint32_t i = 0; i < slides.sliders.size(); ++i) slides.slider_of[slides.sliders[i].root] = i;
}

bool ContactWorld::State::is_followed(std::uint32_t root) const {
  return std::any_of(shoves.followers.begin(), shoves.followers.end(),
                     [&](std::uint32_t follower) { return shoves.leader_of[follower] == root; });
}

/// @pre its commanded path is laid.
void ContactWorld::State::begin_shove(Slider& slider, double stop) const {
  const RigidPath& path = paths[slider.root].carrier();
  const BodyState start = path.at(0, 0.0);
  slider.shoves = true;
  slider.way = (1.0 - stop) * Twist{start.velocity_W, start.angular_velocity_W};
  slider.way_centre_O = transform(inverse(path.from()), start.centre_W);
}

/// After a part that ended at `stop`. @returns whether it shoves on; else it may slide.
bool ContactWorld::State::go_on_shoving(Slider& slider, double stop) const {
  slider.way = (1.0 - stop) * slider.way;
  slider.shoves = stop < 1.0 && !shoves.is_blocked[slider.root];
  const bool may_slide = slides.may_slide[slider.root] && norm(slider.way.w) <= std::numbers::pi;
  slider.done = stop >= 1.0 || (!slider.shoves && !may_slide);
  return slider.shoves;
}

/// What is left of a leader's commanded path: the same motion, evenly on.
RigidPath ContactWorld::State::shoving_path(const Slider& slider) const {
  return RigidPath::by(objects[slider.root].X_WO, slider.way.v, slider.way.w, slider.way_centre_O)
      .ending_at(slider.goal);
}

}  // namespace touchstone
