#include "touchstone/examples/training_run/arm.hpp"

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/ssrms.hpp"

namespace touchstone::training {
namespace {

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

}  // namespace touchstone::training
