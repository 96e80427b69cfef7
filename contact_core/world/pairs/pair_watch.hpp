#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

inline constexpr std::uint32_t kNoLinkPair = kNoIndex;
inline constexpr double kNotKnown = -1.0;

/// Two solids that may come near while neither exceeds its limit (see Travels).
struct WatchedPair {
  using MovesByBits = WatchedPair;  ///< see kMovesByBits

  std::uint32_t a, b;       ///< a < b
  std::uint32_t link_pair;  ///< index into Travels::of_link_pair, or kNoLinkPair
  double clear_until;  ///< it stays apart up to this of the sum of the two solids' travels, or of the pair of
                       ///< links; kNotKnown
  Vector3 axis_W = Vector3::Zero();  ///< from a to b: they were furthest apart along it when last looked at;
                                     ///< zero: not known
};

/// Pairs that come and go one by one, found by either solid. A pair keeps its index while it is here; those
/// of pairs that went are used again, and until then name a pair that is clear for ever. Indices say nothing
/// about order: where order shows, sort by solids. Allocates only where there are more pairs than were
/// reserved.
class PairWatch {
 public:
  /// Makes room for this many, and more (reserve_more.hpp).
  void reserve(std::size_t pairs);
  /// From now on solids below this may be named; those there are keep their pairs.
  void set_solids(std::size_t solids);
  /// The same of pairs of links.
  void set_link_pairs(std::size_t count);
  /// No pairs.
  void clear();

  /// @pre a < b; the two are not watched yet. @returns its index.
  std::uint32_t add(const WatchedPair& pair);
  /// The same, of a pair in which one solid or both are links of arms. @param moving the link, where the
  /// other solid is no link and rests; kNoIndex: both are links, or both move. @param gone of the one that
  /// rests: its travel, which stays as it is [m].
  std::uint32_t add_of_arm(const WatchedPair& pair, SolidIndex moving, double gone = 0.0);
  /// The solid, of no arm, begins to move: in its pairs with arms both may from now on.
  void note_moves(SolidIndex solid);
  /// The solid, of no arm, rests from now on. @param gone its travel [m].
  void note_rests(SolidIndex solid, double gone);
  void remove(std::uint32_t index);
  /// What matters reaches `by` further from now on [m]: all pairs are clear for that much less.
  void shorten_clearances(double by);
  /// kNoIndex: not watched.
  std::uint32_t find(const SolidPair& pair) const;

  /// All indices are below.
  std::uint32_t size() const { return static_cast<std::uint32_t>(pairs_.size()); }
  bool has_any_of(SolidIndex solid) const { return first_[solid] != kNoIndex; }
  std::uint32_t count() const { return count_; }  ///< of the pairs that are watched
  bool is_used(std::uint32_t index) const { return pairs_[index].a != pairs_[index].b; }
  WatchedPair& operator[](std::uint32_t index) { return pairs_[index]; }
  const WatchedPair& operator[](std::uint32_t index) const { return pairs_[index]; }
  SolidPair solids(std::uint32_t index) const { return {pairs_[index].a, pairs_[index].b}; }

  /// Calls visit(index) for each pair of the solid, in no order. visit() may remove that pair, and no other.
  template <class Visit>
  void for_each_of(SolidIndex solid, Visit visit) const {
    for (std::uint32_t place = first_[solid]; place != kNoIndex;) {
      const std::uint32_t index = place / 2;
      place = links_[place].next;
      visit(index);
    }
  }

  /// Calls visit(index) for each pair of an arm that has gone further than it is clear, in no order. An arm
  /// has many pairs, of which few do: those of one solid with what rests, and those of two links, go equally
  /// far on, and are looked at together. Those with solids that move are looked at one by one. visit() may
  /// raise `clear_until`, and adds and removes none.
  /// @param gone gone(pair): how far it has, or may have; the same of pairs that travel alike.
  template <class Gone, class Visit>
  void for_each_of_arms_beyond(Gone gone, Visit visit) {
    for (ArmGroup& group : groups_) {
      const std::uint32_t first = group.near != kNoIndex ? group.near : group.far;
      if (first == kNoIndex) continue;
      // Where what moves, or the two links, went less far than any far pair is clear, all of these are.
      const double of_first = gone(pairs_[first]);
      const double of_mover = (of_first - in_group_[first].gone) + 2.0 * kRounding * of_first;
      if (!group.travels_apart) {
        // One that is no number leaves none far.
        group.most_gone = of_mover < kInfinity ? std::max(group.most_gone, of_mover) : kInfinity;
        if (!(of_mover <= group.least_left)) take_near(group);
      }
      for (std::uint32_t index = group.near; index != kNoIndex;) {
        const std::uint32_t next = in_group_[index].next;
        const bool is_left = !group.travels_apart && of_mover <= left_for_mover(index);
        if (!is_left && !(gone(pairs_[index]) <= pairs_[index].clear_until)) visit(index);
        if (left_for_mover(index) > group.most_gone) take_far(index);
        index = next;
      }
    }
  }

 private:
  /// Pairs of arms that travel alike, but for what the one of the two that rests has gone before.
  struct ArmGroup {
    std::uint32_t near = kNoIndex;  // of the list of those that are looked at
    std::uint32_t far = kNoIndex;   // of the list of the others: these are clear up to most_gone
    bool travels_apart = false;     // those of two movers, which do not travel alike: all are near
    double least_left = kInfinity;  // no left_for_mover() of a far pair is less
    double most_gone = 0.0;         // that the one that moves went, or might have in a plan [m]
  };
  struct InGroup {
    std::uint32_t next, previous;
    double gone;  // what the one that rests has gone, rounded up [m]
  };

  // A pair has two places, 2 index for its a and 2 index + 1 for its b, each in the list of that solid.
  struct Link {
    std::uint32_t next, previous;
  };

  /// Sums of travels round by less than this share of them.
  static constexpr double kRounding = 0x1p-49;

  /// The pair is clear while what moves, or the two links, went no further than this [m].
  double left_for_mover(std::uint32_t index) const {
    return pairs_[index].clear_until - in_group_[index].gone;
  }
  std::uint32_t group_for(const WatchedPair& pair, SolidIndex moving);
  void put_in_group(std::uint32_t index, std::uint32_t place, double gone);
  void take_out_of_group(std::uint32_t index);
  void take_near(ArmGroup& group);
  void take_far(std::uint32_t index);
  void hang(std::uint32_t index, std::uint32_t& list);
  void unhang(std::uint32_t index);
  void put_in(std::uint32_t place, SolidIndex solid);
  void take_out(std::uint32_t place, SolidIndex solid);

  static constexpr double kForever = kInfinity;

  GrowingList<WatchedPair> pairs_;
  GrowingList<Link> links_;           // by place
  GrowingList<std::uint32_t> first_;  // by solid: a place
  GrowingList<std::uint32_t> free_;   // indices
  std::uint32_t count_ = 0;

  GrowingList<ArmGroup> groups_;
  GrowingList<std::uint32_t> group_of_;            // by index of a pair, or kNoIndex
  GrowingList<InGroup> in_group_;                  // by index of a pair
  GrowingList<std::uint32_t> group_of_solid_;      // or kNoIndex
  GrowingList<std::uint32_t> group_of_link_pair_;  // or kNoIndex
  std::uint32_t group_of_two_movers_ = kNoIndex;
};

}  // namespace touchstone
