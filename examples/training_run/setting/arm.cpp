#include "touchstone/examples/training_run/setting/arm.hpp"

#include <algorithm>
#include <span>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"

namespace touchstone::training {
namespace {

/// Held joints keep where they are, against a slide as against a hand: assumed as stiff as that.
constexpr double kHeldWeight = 1e4;
/// Jaws give way to what they meet rather than shift their arm.
constexpr double kJawWeight = 1e-4;

void add_weights(const std::vector<std::string>& held_joints, Arm& arm) {
  const Mechanism& mechanism = *arm.mechanism;
  arm.weights.assign(mechanism.value_count(), 1.0);
  const std::span<const std::uint32_t> chain = mechanism.chain(arm.flown_link);
  for (std::uint32_t j = 0; j < mechanism.joints().size(); ++j) {
    const Mechanism::Joint& joint = mechanism.joints()[j];
    const bool is_jaw =
        joint.kind == JointKind::prismatic && std::find(chain.begin(), chain.end(), j) == chain.end();
    if (is_jaw) arm.weights[joint.value] = kJawWeight;
  }
  for (const std::string& name : held_joints) {
    arm.held_values.push_back(mechanism.joints()[mechanism.find_joint(name)].value);
    arm.weights[arm.held_values.back()] = kHeldWeight;
  }
}

Arm make_arm(const ArmScript& script) {
  Arm arm;
  arm.mechanism = script.mechanism;
  if (!arm.mechanism) arm.mechanism = std::make_shared<const Mechanism>(make_bundled_arm(script.model));
  const Mechanism& mechanism = *arm.mechanism;
  arm.flown_link = mechanism.find_link(script.link);
  arm.joints = script.joints;
  arm.holds = script.holds;
  if (arm.joints.size() != mechanism.value_count())
    throw InputError("arm '" + script.model + "': " + std::to_string(arm.joints.size()) +
                     " joint values for " + std::to_string(mechanism.value_count()) + " joints");
  if (!mechanism.is_within_limits(arm.joints))
    throw InputError("arm '" + script.model + "': joint values out of limits");
  std::vector<Pose> X_BL(mechanism.links().size());
  mechanism.link_poses({}, arm.joints, X_BL);
  arm.X_WB = rigid_frame(compose(script.X_WL, inverse(X_BL[arm.flown_link])));
  add_weights(script.held_joints, arm);
  return arm;
}

void add_links(Arm& arm, Scene& scene) {
  const Mechanism& mechanism = *arm.mechanism;
  std::vector<Pose> X_WL(mechanism.links().size());
  mechanism.link_poses(arm.X_WB, arm.joints, X_WL);
  arm.first_object = static_cast<std::uint32_t>(scene.objects.size());
  for (std::uint32_t link = 0; link < X_WL.size(); ++link) {
    const auto& tree = mechanism.links()[link].tree;
    arm.object_of_link.push_back(tree ? static_cast<std::uint32_t>(scene.objects.size()) : Mechanism::kNone);
    if (!tree) continue;
    arm.link_of_object.push_back(link);
    scene.objects.push_back({*tree, X_WL[link], {}, {}});
  }
  arm.object_count = static_cast<std::uint32_t>(arm.link_of_object.size());
}

void add_exempt_pairs(const Mechanism& mechanism, Scene& scene) {
  const auto count = static_cast<std::uint32_t>(mechanism.solids().size());
  const auto name = [&](std::uint32_t solid) {
    return mechanism.links()[mechanism.link_of(solid)].tree->name() + "/" + mechanism.placed(solid).name;
  };
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (mechanism.link_of(a) != mechanism.link_of(b) && mechanism.is_exempt(a, b))
        scene.exempt_pairs.push_back({name(a), name(b)});
}

}  // namespace

std::vector<Arm> add_arms(Script& script) {
  std::vector<Arm> arms;
  std::size_t first_value = 0;
  for (std::size_t hand = 0; hand < script.hands.size(); ++hand) {
    if (!script.hands[hand].arm) continue;
    Arm arm = make_arm(*script.hands[hand].arm);
    arm.hand = hand;
    arm.first_value = first_value;
    first_value += arm.joints.size();
    add_links(arm, script.scene);
    add_exempt_pairs(*arm.mechanism, script.scene);
    arms.push_back(std::move(arm));
  }
  return arms;
}

Arm held_by(const Arm& arm, std::uint32_t base, const Pose& X_WB, std::uint32_t flown_link,
            std::span<const double> joints) {
  Arm out = arm;
  const std::string& link = arm.mechanism->links()[base].name;
  out.mechanism = std::make_shared<const Mechanism>(arm.mechanism->with_base(link));
  out.X_WB = rigid_frame(X_WB);
  out.flown_link = flown_link;
  out.joints.assign(joints.begin(), joints.end());
  return out;
}

}  // namespace touchstone::training
