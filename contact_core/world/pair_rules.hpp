#pragma once

#include <algorithm>
#include <vector>

#include "touchstone/contact_core/world/object_table.hpp"

namespace touchstone {

/// Which rule a pair of objects follows: its own, else that of the last group rule that fits, else the
/// default.
class PairRules {
 public:
  void set_default(const PairRule& rule) { default_ = rule; }
  void set_for_groups(std::uint32_t first, std::uint32_t second, const PairRule& rule) {
    for_groups_.push_back({first, second, rule});
  }
  void set_for_pair(std::uint32_t a, std::uint32_t b, const PairRule& rule);
  void forget(std::uint32_t slot);

  const PairRule& find(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const;
  double largest_warn_distance() const;

 private:
  struct Entry {
    std::uint32_t first, second;
    PairRule rule;
  };

  PairRule default_;
  std::vector<Entry> for_groups_;
  std::vector<Entry> for_pairs_;  // slots, first < second, sorted
};

/// What is switched on.
class Selection {
 public:
  void apply(const SelectionChange& change);
  void select_all() { *this = {}; }
  void forget(std::uint32_t slot);
  bool is_on(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const;

  /// apply() then does not allocate while no more than kPairRoom pairs are off by themselves.
  void reserve(std::size_t objects) {
    objects_off_.reserve(objects);
    pairs_off_.reserve(std::min(kPairRoom, objects * objects / 2));
  }
  static constexpr std::size_t kPairRoom = 65536;

 private:
  bool everything_ = true;
  std::uint64_t groups_off_ = 0;
  std::vector<std::uint32_t> objects_off_;                          // sorted
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_off_;  // sorted, first < second
};

}  // namespace touchstone
