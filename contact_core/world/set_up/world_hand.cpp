#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/set_up/world_state.hpp"

// How stiffly hands hold what they fly: set-up. Slides by it are in slide/slides.cpp.

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

void check_hand(const HandStiffness& hand, double longest_lever, const std::string& label) {
  if (hand.X_OT) {
    validate_pose(*hand.X_OT, label + ", tool frame");
    if (!(norm(hand.X_OT->p) <= longest_lever))
      throw InputError(label + ": its tool frame is " + std::to_string(norm(hand.X_OT->p)) +
                       " m from the object's origin, where poses round by more than the gap allows");
  }
  const double least = hand.translation.minCoeff();
  if (!std::isfinite(least) || !(least > 0.0))
    throw InputError(label + ": a stiffness against translation is not a number above 0");
  check_stiffness(hand.translation, least, kMostRatio * least, label + ": a stiffness against translation");
  check_stiffness(hand.turning, least / kMostRatio, kMostRatio * least,
                  label + ": a stiffness against turning");
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

void ContactWorld::set_default_hand(const std::optional<HandStiffness>& hand) {
  if (hand && hand->X_OT) throw InputError("contact world, default hand: a tool frame is of one object");
  if (hand) check_hand(*hand, longest_lever(state_->gap), "contact world, default hand");
  state_->slides.hands.set_default(hand);
}

}  // namespace touchstone
