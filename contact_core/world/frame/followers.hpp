#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

/// The roots that other movers take along in a frame, and their leaders; by slots.
class Followers {
 public:
  /// The leader that a root goes along with, and the leader's link; 0 for a rigid leader.
  struct Lead {
    std::uint32_t root, link;

    friend bool operator==(const Lead&, const Lead&) = default;
  };

  /// @param anew forgets all leaders.
  void take_room(std::size_t slots, bool anew) {
    if (anew) *this = {};
    resize_more(leader_of_, slots, kNoIndex), resize_more(claim_of_, slots, {kNoIndex, 0});
    for (GrowingList<std::uint8_t>* flags : {&is_commanded_, &is_disputed_, &is_blocked_})
      resize_more(*flags, slots);
    for (std::vector<std::uint32_t>* roots : {&followers_, &claimed_}) reserve_more(*roots, slots);
  }
  /// A frame begins. @param commanded_before of the last one. @param commanded roots with a command of their
  /// own.
  void begin(std::span<const std::uint32_t> commanded_before, std::span<const std::uint32_t> commanded) {
    for (const std::uint32_t root : followers_) leader_of_[root] = kNoIndex;
    followers_.clear();
    for (const std::uint32_t root : commanded_before) is_commanded_[root] = 0;
    for (const std::uint32_t root : commanded) is_commanded_[root] = 1;
  }
  void nothing_is_disputed() { std::fill(is_disputed_.begin(), is_disputed_.end(), std::uint8_t{0}); }

  /// The roots that go along, in the order in which they were taken along.
  std::span<const std::uint32_t> all() const { return followers_; }
  /// The root by whose motion this one goes: its own, unless it goes along.
  std::uint32_t leader_of(std::uint32_t root) const {
    return leader_of_[root] == kNoIndex ? root : leader_of_[root];
  }
  bool is_followed(std::uint32_t root) const {
    return std::any_of(followers_.begin(), followers_.end(),
                       [&](std::uint32_t follower) { return leader_of_[follower] == root; });
  }
  /// Whether the root is commanded in this frame or goes along.
  bool is_commanded(std::uint32_t root) const { return is_commanded_[root] != 0; }
  /// Whether two leaders claimed it, or two links of one: then it stays.
  bool is_disputed(std::uint32_t root) const { return is_disputed_[root] != 0; }

  /// Whether something that does not go along stopped the leader.
  bool is_blocked(std::uint32_t root) const { return is_blocked_[root] != 0; }
  void set_blocked(std::uint32_t root, bool is_blocked) { is_blocked_[root] = is_blocked; }

  /// A leader claims a root. Claims come in any order, and may come more than once.
  void claim(const Lead& lead, std::uint32_t root) {
    Lead& wanted = claim_of_[root];
    if (wanted.root == kNoIndex) claimed_.push_back(root);
    const bool is_disputed = wanted.root != kNoIndex && wanted != lead;
    wanted = is_disputed || is_disputed_[root] ? Lead{root, 0} : lead;
    is_disputed_[root] = is_disputed_[root] || is_disputed;
  }
  /// Each root that only one leader claims goes along with it. Calls take(lead, root), ascending roots.
  /// @returns whether there is any.
  template <class Take>
  bool settle(Take take) {
    std::sort(claimed_.begin(), claimed_.end());
    bool any = false;
    for (const std::uint32_t root : claimed_) {
      const Lead lead = claim_of_[root];
      claim_of_[root] = {kNoIndex, 0};
      if (is_disputed_[root]) continue;
      leader_of_[root] = lead.root;
      followers_.push_back(root);
      is_commanded_[root] = 1;
      take(lead, root);
      any = true;
    }
    claimed_.clear();
    return any;
  }

 private:
  GrowingList<std::uint32_t> leader_of_;  // by slot; kNoIndex: it goes by itself, or not at all
  std::vector<std::uint32_t> followers_;
  GrowingList<Lead> claim_of_;                                         // by slot: whom it is to go along with
  std::vector<std::uint32_t> claimed_;                                 // slots
  GrowingList<std::uint8_t> is_commanded_, is_disputed_, is_blocked_;  // by slot
};

}  // namespace touchstone
