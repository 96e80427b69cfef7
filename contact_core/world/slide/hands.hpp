#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

/// The hands that hold objects: ContactWorld::set_hand().
class Hands {
 public:
  void set(ObjectHandle object, const std::optional<HandStiffness>& hand) {
    if (by_slot_.size() <= object.slot) by_slot_.resize(object.slot + 1);
    by_slot_[object.slot] = {object, hand};
  }
  void set_default(const std::optional<HandStiffness>& hand) { default_ = hand; }
  /// None: the object's mass.
  const std::optional<HandStiffness>& of(ObjectHandle object) const {
    const bool has_own = object.slot < by_slot_.size() && by_slot_[object.slot].object == object;
    return has_own ? by_slot_[object.slot].hand : default_;
  }

 private:
  struct Entry {
    ObjectHandle object;  // or it is of one that has gone
    std::optional<HandStiffness> hand;
  };
  std::optional<HandStiffness> default_ = HandStiffness{};
  std::vector<Entry> by_slot_;
};

}  // namespace touchstone
