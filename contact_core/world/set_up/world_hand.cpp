#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/set_up/world_state.hpp"

// How stiffly hands hold what they fly: set-up. Slides by it are in slide/slides.cpp and slide/arm_hand.cpp.

namespace touchstone {
namespace {

/// Between the least and the largest of a tool frame's stiffnesses: more would leave the metric of a slide
/// few digits.
constexpr double kMostRatio = 1e6;

void check_stiffness(const Vector3& values, double least, double most, const std::string& label) {
  for (int i = 0; i < 3; ++i)
    if (!(values[i] >= least && values[i] <= most))
      throw InputError(label + " of " + std::to_string(values[i]) + " is not within " +
                       std::to_string(least) + " and " + std::to_string(most));
}

void check_tool(const Vector3& translation, const Vector3& turning, const std::string& label) {
  const double least = translation.minCoeff();
  if (!std::isfinite(least) || !(least > 0.0))
    throw InputError(label + ": a stiffness against translation is not a number above 0");
  check_stiffness(translation, least, kMostRatio * least, label + ": a stiffness against translation");
  check_stiffness(turning, least / kMostRatio, kMostRatio * least, label + ": a stiffness against turning");
}

void check_tool_frame(const Pose& X_FT, double longest_lever, const std::string& label) {
  validate_pose(X_FT, label + ", tool frame");
  if (!(norm(X_FT.p) <= longest_lever))
    throw InputError(label + ": its tool frame is " + std::to_string(norm(X_FT.p)) +
                     " m from the object's origin, where poses round by more than the gap allows");
}

void check_hand(const HandStiffness& hand, double longest_lever, const std::string& label) {
  if (hand.X_OT) check_tool_frame(*hand.X_OT, longest_lever, label);
  check_tool(hand.translation, hand.turning, label);
}

/// Of the least stiffness against translation: what joints hold by where their hand does not say.
constexpr double kJointShare = 0.01;

std::vector<double> joint_stiffness(const ArmHandStiffness& hand, std::size_t values,
                                    const std::string& label) {
  const double least = hand.translation.minCoeff();
  if (hand.joints.empty()) return std::vector<double>(values, kJointShare * least);
  if (hand.joints.size() != values)
    throw InputError(label + ": " + std::to_string(hand.joints.size()) + " stiffnesses for " +
                     std::to_string(values) + " joints that move");
  for (const double stiffness : hand.joints)
    if (!(stiffness >= least / kMostRatio && stiffness <= kMostRatio * least))
      throw InputError(label + ": a joint's stiffness of " + std::to_string(stiffness) + " is not within " +
                       std::to_string(least / kMostRatio) + " and " + std::to_string(kMostRatio * least));
  return hand.joints;
}

}  // namespace

void ContactWorld::set_hand(ObjectHandle object, const std::optional<HandStiffness>& hand) {
  State& s = *state_;
  const std::uint32_t slot = s.objects.slot_of(object);
  const std::string label = "object '" + std::string(name_of(object)) + "', hand";
  if (s.objects[slot].is_link()) throw InputError(label + ": it is a mechanism's link, which joints move");
  if (hand) check_hand(*hand, longest_lever(s.gap), label);
  s.slides.hands.set(object, hand);
}

void ContactWorld::set_hand(MechanismHandle mechanism, const std::optional<ArmHandStiffness>& hand) {
  MechanismMover& arm = state_->mechanisms.get(mechanism);
  if (!hand) {
    arm.weights = arm.own_weights;
    arm.hand = nullptr;
    return;
  }
  const std::string label = "mechanism '" + arm.mechanism->name() + "', hand";
  const std::uint32_t link = arm.mechanism->find_link(hand->link);
  const auto chain = arm.mechanism->chain(link);
  const bool moves = std::any_of(chain.begin(), chain.end(), [&](std::uint32_t joint) {
    return arm.mechanism->joints()[joint].value != Mechanism::kNone;
  });
  if (!moves) throw InputError(label + ": no joint moves link '" + hand->link + "'");
  check_tool_frame(hand->X_LT, longest_lever(state_->gap), label);
  check_tool(hand->translation, hand->turning, label);
  std::vector<double> joints = joint_stiffness(*hand, arm.own_weights.size(), label);
  arm.hand = std::make_unique<ArmHand>(ArmHand{link, hand->X_LT, hand->translation, hand->turning});
  arm.weights = std::move(joints);
}

void ContactWorld::set_default_hand(const std::optional<HandStiffness>& hand) {
  if (hand && hand->X_OT) throw InputError("contact world, default hand: a tool frame is of one object");
  if (hand) check_hand(*hand, longest_lever(state_->gap), "contact world, default hand");
  state_->slides.hands.set_default(hand);
}

}  // namespace touchstone
