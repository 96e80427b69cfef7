#pragma once

#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/pair_watch.hpp"

namespace touchstone {

/// When in a frame something happened to a pair, and how the two stood then.
struct Moment {
  std::uint32_t part;  ///< see ContactWorld::executed_parts()
  double s;
  PairGeometry geometry;
};
inline constexpr std::uint32_t kNoMoment = 0xffffffff;
inline constexpr double kNotStopped = -1.0;

/// A pair that matters in this frame.
struct FramePair {
  SolidPair solids;
  EffectiveRule rule;
  double gap;
  double interest;  ///< further apart than this nothing is reported [m]
  Impact impact;
  std::uint32_t own = kNotOwn;      ///< of two links of a mechanism: see Travels
  double clear_until = kNotKnown;   ///< it stays further apart than `interest` while Travels has no more
  std::uint32_t watch = 0;          ///< its index among the watched pairs, while these are looked through
  double start_separation = 0.0;    ///< as the frame starts [m]; of an own pair: infinity
  double way = 0.0;                 ///< how far the plan at hand may bring the two together [m]
  bool is_settled = false;          ///< its stop is in force
  bool is_active = false;           ///< it holds back a sub-step's plan
  double stopped_at = kNotStopped;  ///< s of the part at hand at which it stopped a mover
  std::uint32_t stop = kNoMoment;   ///< the first at which it stopped a mover: index into State::moments
  std::uint32_t touch = kNoMoment;  ///< the first at which it was found within the gap, of what was executed

  bool stops_movers() const {
    return impact.status != ImpactStatus::clear && rule.policy != ContactPolicy::cue;
  }
  bool is_open() const { return stops_movers() && !is_settled; }
  bool holds() const { return rule.policy == ContactPolicy::hold; }
  bool has_moment() const { return stop != kNoMoment || touch != kNoMoment; }
};

/// A pair in contact at the end of a frame.
struct ContactState {
  SolidPair solids;
  PairGeometry geometry;
};

}  // namespace touchstone
