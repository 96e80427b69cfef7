#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/world/contact_world.hpp"

// A contact world under random treatment, every invariant checked after every frame: commands good and bad,
// selections from another thread, latches, exemptions, additions, removals, rules and resets, many of them
// refused.

namespace touchstone {

struct Soak {
  std::uint64_t frames = 2000;
  std::uint64_t seed = 1;
  /// Null: another thread selects while frames run. Else these, at the frames they came into force.
  const std::vector<SelectionRecord>* replay = nullptr;
};

struct SoakFigures {
  std::uint64_t frames = 0, commands = 0, refused = 0, blocked = 0, slid = 0;
  std::uint64_t added = 0, removed = 0, latched = 0, unlatched = 0, resets = 0, rules = 0;
  std::uint64_t exempted = 0, refused_selections = 0;
  std::uint64_t refused_set_up = 0;  ///< double latches, unknown handles, removals while latched ...
  std::uint64_t selections = 0, contact_events = 0, pairs_checked = 0, iteration_limits = 0;
  std::uint64_t overlapping_starts = 0;
  std::uint64_t pose_hash = 0;  ///< over every actual pose of every frame
  double worst_rotation = 0.0;  ///< |R^T R - I|, any element
  double worst_growth = 0.0;    ///< of the depth of a pair that overlapped at its frame's start [m]
  std::string violation;        ///< the first, empty: none; the run ends there
  std::vector<SelectionRecord> record;
};

SoakFigures soak(const Soak& run);

std::string describe(const SoakFigures& figures);

}  // namespace touchstone
