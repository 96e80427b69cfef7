#include "touchstone/examples/station/flight/tips.hpp"

#include <algorithm>

namespace touchstone::station {
namespace {

using training::Arm;

Tip make_tip(const Arm& arm, std::uint32_t link) {
  const Mechanism& mechanism = *arm.mechanism;
  Tip tip{mechanism.links()[link].name, link};
  tip.object = arm.first_object;
  for (const std::uint32_t joint : mechanism.chain(link)) {
    const std::uint32_t outer = mechanism.joints()[joint].outer;
    if (arm.object_of_link[outer] != Mechanism::kNone) tip.object = arm.object_of_link[outer];
  }
  std::vector<Pose> X_WL(mechanism.links().size());
  mechanism.link_poses(arm.X_WB, arm.joints, X_WL);
  const std::uint32_t hand = arm.link_of_object[tip.object - arm.first_object];
  tip.X_HT = compose(inverse(X_WL[hand]), X_WL[link]);
  for (const Mechanism::Joint& joint : mechanism.joints())
    if (joint.kind == JointKind::prismatic && joint.inner == hand &&
        arm.object_of_link[joint.outer] != Mechanism::kNone)
      tip.jaws.push_back({joint.value, arm.object_of_link[joint.outer]});
  return tip;
}

bool is_end(const Arm& arm, std::uint32_t link, bool walks) {
  const Mechanism& mechanism = *arm.mechanism;
  const auto& joints = mechanism.joints();
  if (mechanism.links()[link].tree || link == arm.flown_link) return false;
  if (std::any_of(joints.begin(), joints.end(), [&](const auto& joint) { return joint.inner == link; }))
    return false;
  if (walks) return true;
  const auto is_held = [&](std::uint32_t value) {
    return std::find(arm.held_values.begin(), arm.held_values.end(), value) != arm.held_values.end();
  };
  const std::span<const std::uint32_t> chain = mechanism.chain(link);
  return std::any_of(chain.begin(), chain.end(), [&](std::uint32_t joint) {
    return joints[joint].value != Mechanism::kNone && !is_held(joints[joint].value);
  });
}

}  // namespace

std::vector<Tip> find_tips(const training::Setting& setting, bool walks) {
  if (setting.arms().empty()) {
    const std::uint32_t object = setting.object_of_hand(0);
    return {Tip{setting.object_name(object), training::kNone, object}};
  }
  const Arm& arm = setting.arms()[0];
  std::vector<Tip> tips = {make_tip(arm, arm.flown_link)};
  for (std::uint32_t link = 0; link < arm.mechanism->links().size(); ++link)
    if (is_end(arm, link, walks)) tips.push_back(make_tip(arm, link));
  return tips;
}

}  // namespace touchstone::station
