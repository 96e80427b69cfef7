#pragma once

#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/travels.hpp"

namespace touchstone {

/// A pair that matters in this frame.
struct FramePair {
  SolidPair solids;
  EffectiveRule rule;
  double gap;
  double interest;  ///< further apart than this nothing is reported [m]
  Impact impact;
  std::uint32_t own = kNotOwn;     ///< of two links of a mechanism: see Travels
  double clear_until = kNotKnown;  ///< it stays further apart than `interest` while Travels has no more
  std::uint32_t watch = 0;         ///< its index among the watched pairs, while these are looked through
  double start_separation = 0.0;   ///< as the frame starts [m]; of an own pair: infinity
  double way = 0.0;                ///< how far the plan at hand may bring the two together [m]
  bool is_settled = false;         ///< its stop is in force
  bool has_blocked = false;        ///< it stopped a mover
  double blocked_at = 1.0;

  bool stops_movers() const {
    return impact.status != ImpactStatus::clear && rule.policy != ContactPolicy::cue;
  }
};

/// A pair in contact at the end of a frame.
struct ContactState {
  SolidPair solids;
  PairGeometry geometry;
};

}  // namespace touchstone
