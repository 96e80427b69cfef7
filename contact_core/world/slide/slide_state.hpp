#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/world/slide/hands.hpp"
#include "touchstone/contact_core/world/slide/slide_pairs.hpp"

namespace touchstone {

/// What the stops of a part allow their movers, by slot.
struct StopPermits {
  std::vector<std::uint8_t> may_slide;                // what stopped it last lets it slide
  std::vector<std::uint8_t> may_pivot;                // or lets it advance
  std::vector<std::uint8_t> translation_only;         // it goes on without turning
  std::vector<std::uint8_t> translation_only_before;  // the same, as the part at hand began

  void take_room(std::size_t slots, bool anew) {
    for (std::vector<std::uint8_t>* flags :
         {&may_slide, &may_pivot, &translation_only, &translation_only_before}) {
      if (anew) flags->clear();
      flags->resize(slots, 0);
    }
  }
  /// @param as_well another pair stopped the mover at the same s.
  void note_stop(std::uint32_t root, const EffectiveRule& rule, bool as_well) {
    const bool slides = rule.policy == ContactPolicy::slide;
    may_slide[root] = slides && (!as_well || may_slide[root]);
    may_pivot[root] = rule.policy != ContactPolicy::hold && (!as_well || may_pivot[root]);
    if (slides && rule.translation_only) translation_only[root] = 1;
  }
};

/// An object's share in what moves as one.
struct CarriedMoments {
  std::uint32_t root;
  MassMoments moments;

  /// Of one root by values alone: sums round alike in whichever order the objects were registered.
  friend bool operator<(const CarriedMoments& a, const CarriedMoments& b) {
    if (a.root != b.root) return a.root < b.root;
    if (a.moments.volume != b.moments.volume) return a.moments.volume < b.moments.volume;
    for (int i = 0; i < 3; ++i)
      if (a.moments.first[i] != b.moments.first[i]) return a.moments.first[i] < b.moments.first[i];
    for (int i = 0; i < 9; ++i)
      if (a.moments.second(i / 3, i % 3) != b.moments.second(i / 3, i % 3))
        return a.moments.second(i / 3, i % 3) < b.moments.second(i / 3, i % 3);
    return false;
  }
};

/// What slides keep: their settings, and the memory of one frame.
struct SlideState {
  Hands hands;
  SlideBudget budget;

  StopPermits permits;
  std::vector<MassMoments> moments;     // by solid, in its object
  std::vector<CarriedMoments> carried;  // of the sliders' objects, sorted
  Sliders sliders;
  SlidePairs pairs;
  SlideMeter meter;
  /// By root: pairs that stopped it on its commanded path, and where each root's are.
  std::vector<FramePair> touching;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> touching_of;  // (root, index into the frame's pairs)
  std::vector<SlideRow> rows;                                        // of one plan
  std::vector<JointRow> joint_rows;                                  // of an arm: rows[i] in its joint values

  std::vector<HandFeel> felt;         // what FrameReport shows
  std::vector<ObjectHandle> cut_off;  // the same
};

}  // namespace touchstone
