#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/objects/object_table.hpp"

namespace touchstone {

/// Decides which rule a pair of objects follows. Each field comes from the pair's own rule, else from the
/// last group rule that fits and sets it, else from the default rule, else from EffectiveRule. A rule set
/// again replaces the one before; an empty one takes it back. A pair's rule ends with either object. Memory
/// is bounded by the rules in force.
class PairRules {
 public:
  /// @throws InputError: a warn distance that is not finite or below 0. The next three do so, too.
  static void check(const PairRule& rule);
  void set_default(const PairRule& rule);
  /// Groups by index; the two in either order are the same.
  void set_for_groups(const ObjectTable& objects, std::uint32_t first, std::uint32_t second,
                      const PairRule& rule);
  /// Allocates where the two had none and the rules in force outgrow all before.
  /// @pre both are alive.
  void set_for_pair(const ObjectTable& objects, ObjectHandle a, ObjectHandle b, const PairRule& rule);

  /// Slots of objects that are alive.
  EffectiveRule find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const;
  /// False: no rule was ever set by which anything passive moves.
  bool moves_passive() const { return moves_passive_; }
  // Which objects have to look further than the default rule's warn distance: of each rule that has a warn
  // distance one side bears it, of two groups the one that was the smaller when the rule was set.

  /// At least what the rules that the object bears ask for [m]: of groups, not of pairs.
  double reach_of(const ObjectTable& objects, std::uint32_t slot) const;
  /// Raises each slot's reach to what its rules and those of its pairs ask. @param by_slot [m].
  void find_reaches(const ObjectTable& objects, std::span<double> by_slot) const;
  double largest_group_warn_distance() const;
  /// Which of two groups bears a rule.
  std::uint32_t bearer_of(std::uint32_t first, std::uint32_t second) const;

  /// At least that of every rule there was [m].
  double largest_warn_distance() const { return largest_warn_; }
  PairRule default_rule() const { return default_; }
  /// The rule of two groups as it was set, or an empty one.
  PairRule rule_of_groups(std::uint32_t first, std::uint32_t second) const;
  /// Places for rules of pairs, in use or not.
  std::size_t room() const { return for_pairs_.size(); }

 private:
  struct GroupEntry {
    std::uint32_t first, second;  // ordered
    PairRule rule;
    std::uint32_t bearer;  // of the two
  };
  /// An entry of a table with open addressing and linear probing; a free one has no handle.
  struct PairEntry {
    ObjectHandle a, b;  // ordered
    PairRule rule;

    bool is_free() const { return a == ObjectHandle{}; }
  };

  static constexpr std::size_t kNone = ~std::size_t{0};

  void note(const PairRule& rule);
  std::size_t home_of(const ObjectHandle& a, const ObjectHandle& b) const;
  /// Where the pair's rule is, or kNone.
  std::size_t place_of(const ObjectHandle& a, const ObjectHandle& b) const;
  void put(const PairEntry& entry);
  void take_out(std::size_t place);
  void make_room(const ObjectTable& objects);

  bool moves_passive_ = false;
  double largest_warn_ = EffectiveRule{}.warn_distance;
  PairRule default_;
  std::vector<GroupEntry> for_groups_;  // in the order in which they were given; at most one for two groups
  std::vector<PairEntry> for_pairs_;    // a power of two, or none; never more than half full
  std::size_t used_ = 0;                // of for_pairs_
};

}  // namespace touchstone
