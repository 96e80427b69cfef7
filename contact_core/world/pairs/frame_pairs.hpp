#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/pairs/pair_watch.hpp"

namespace touchstone {

/// When in a frame something happened to a pair, and how the two stood then.
struct Moment {
  std::uint32_t part;  ///< see ContactWorld::executed_parts()
  double s;
  PairGeometry geometry;
};
inline constexpr std::uint32_t kNoMoment = kNoIndex;
inline constexpr double kNotStopped = -1.0;

/// The distances that decide about a pair [m].
struct PairDistances {
  double gap;
  double interest;  ///< further apart than this nothing is reported
};

/// A pair that matters in this frame.
struct FramePair : PairDistances {
  using MovesByBits = FramePair;  ///< see kMovesByBits

  SolidPair solids;
  EffectiveRule rule;
  Impact impact;
  std::uint32_t link_pair = kNoLinkPair;  ///< of two links of a mechanism: see Travels
  double clear_until = kNotKnown;   ///< it stays further apart than `interest` while Travels has no more
  std::uint32_t watch = 0;          ///< its index among the watched pairs, while these are looked through
  double start_separation = 0.0;    ///< as the frame starts [m]; of two links of one arm: infinity
  double approach = 0.0;            ///< how far the plan at hand may bring the two together [m]
  bool is_settled = false;          ///< its stop is in force
  bool is_active = false;           ///< it holds back a sub-step's plan
  double stopped_at = kNotStopped;  ///< s of the part at hand at which it stopped a mover
  std::uint32_t stop = kNoMoment;   ///< the first at which it stopped a mover: index into the MomentLog
  std::uint32_t touch = kNoMoment;  ///< the first at which it was found within the gap, of what was executed

  bool stops_movers() const {
    return impact.status != ImpactStatus::clear && rule.policy != ContactPolicy::cue;
  }
  bool is_open() const { return stops_movers() && !is_settled; }
  bool holds() const { return rule.policy == ContactPolicy::hold; }
  bool has_moment() const { return stop != kNoMoment || touch != kNoMoment; }
};

/// One of the watched pairs, to be put in the order of their solids wherever it was found.
struct GatheredPair {
  SolidPair solids;
  std::uint32_t watch;

  friend bool operator<(const GatheredPair& a, const GatheredPair& b) { return a.solids < b.solids; }
};

/// A pair in contact at the end of a frame.
struct ContactState {
  SolidPair solids;
  PairGeometry geometry;
};

/// Whether the pair is one of these, which are sorted by solids.
template <class Entry>
bool is_among(std::span<const Entry> entries, const SolidPair& pair) {
  const auto place = std::lower_bound(entries.begin(), entries.end(), pair,
                                      [](const Entry& x, const SolidPair& y) { return x.solids < y; });
  return place != entries.end() && place->solids == pair;
}

/// Brings pairs into the order of their solids of which the first `known` are in it, and the others come in
/// any. Allocates where there is no room for those once more.
inline void merge_by_solids(GrowingList<FramePair>& pairs, std::size_t known) {
  const auto before = [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; };
  const std::size_t count = pairs.size(), fresh = count - known;
  const auto middle = pairs.begin() + static_cast<std::ptrdiff_t>(known);
  if (fresh == 0) return;
  if (!std::is_sorted(middle, pairs.end(), before)) std::sort(middle, pairs.end(), before);
  if (known == 0 || !before(*middle, *(middle - 1))) return;
  // The fresh ones make room behind all others, and the largest of both go to the back.
  pairs.resize(count + fresh);
  std::copy_n(pairs.begin() + static_cast<std::ptrdiff_t>(known), fresh,
              pairs.begin() + static_cast<std::ptrdiff_t>(count));
  std::size_t known_end = known, fresh_end = count + fresh;
  for (std::size_t out = count; fresh_end > count;) {
    const bool is_known = known_end > 0 && before(pairs[fresh_end - 1], pairs[known_end - 1]);
    pairs[--out] = is_known ? pairs[--known_end] : pairs[--fresh_end];
  }
  pairs.resize(count);
}

}  // namespace touchstone
