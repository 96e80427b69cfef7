#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/world/object_table.hpp"

namespace touchstone {

/// Which rule a pair of objects follows: field by field its own, else that of the last group rule that fits
/// and sets it, else the default's, else EffectiveRule's. A rule set again replaces the one before; an empty
/// one takes it back.
class PairRules {
 public:
  /// @throws InputError: a warn distance that is not finite or below 0. The next three do so, too.
  static void check(const PairRule& rule);
  void set_default(const PairRule& rule);
  /// Groups by index; the two in either order are the same.
  void set_for_groups(std::uint32_t first, std::uint32_t second, const PairRule& rule);
  /// Slots.
  void set_for_pair(std::uint32_t a, std::uint32_t b, const PairRule& rule);
  void forget(std::uint32_t slot);

  EffectiveRule find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const;
  double largest_warn_distance() const;

 private:
  struct Entry {
    std::uint32_t first, second;  // ordered
    PairRule rule;
  };

  PairRule default_;
  std::vector<Entry> for_groups_;  // in the order in which they were given; at most one for two groups
  std::vector<Entry> for_pairs_;   // sorted
};

}  // namespace touchstone
