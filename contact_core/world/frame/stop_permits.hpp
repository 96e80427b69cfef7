#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

/// How movers may go on after the stops of a part, by slot.
struct StopPermits {
  GrowingList<std::uint8_t> may_slide;                // what stopped it last lets it slide
  GrowingList<std::uint8_t> may_pivot;                // or lets it advance
  GrowingList<std::uint8_t> translation_only;         // it goes on without turning
  GrowingList<std::uint8_t> translation_only_before;  // the same, as the part at hand began

  void take_room(std::size_t slots, bool anew) {
    for (GrowingList<std::uint8_t>* flags :
         {&may_slide, &may_pivot, &translation_only, &translation_only_before}) {
      if (anew) flags->clear();
      resize_more(*flags, slots);
    }
  }
  /// A frame begins: nothing has stopped these roots yet.
  void forget(std::span<const std::uint32_t> roots) {
    for (const std::uint32_t root : roots) may_slide[root] = may_pivot[root] = translation_only[root] = 0;
  }
  /// @param as_well another pair stopped the mover at the same s.
  void note_stop(std::uint32_t root, const EffectiveRule& rule, bool as_well) {
    const bool slides = rule.policy == ContactPolicy::slide;
    may_slide[root] = slides && (!as_well || may_slide[root]);
    may_pivot[root] = rule.policy != ContactPolicy::hold && (!as_well || may_pivot[root]);
    if (slides && rule.translation_only) translation_only[root] = 1;
  }
};

}  // namespace touchstone
