#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/world/objects/mechanism_mover.hpp"
#include "touchstone/contact_core/world/objects/object_table.hpp"
#include "touchstone/contact_core/world/selection.hpp"

namespace touchstone {

/// Changes on their way from any thread to the frame loop, in the order in which they came.
class SelectionQueue {
 public:
  void push(const SelectionChange& change) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(change);
  }

  /// Swaps the waiting changes into `out` (cleared first), so that no memory changes hands once both are
  /// warm.
  void take(std::vector<SelectionChange>& out) {
    out.clear();
    const std::lock_guard lock(mutex_);
    waiting_.swap(out);
  }

  void clear() {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
  }

  void reserve(std::size_t count) {
    const std::lock_guard lock(mutex_);
    waiting_.reserve(count);
  }

 private:
  std::mutex mutex_;
  std::vector<SelectionChange> waiting_;
};

/// The state of all switches.
class Selection {
 public:
  /// Returns false, nothing changed, where the change names what is gone, an object twice, or a group that
  /// nobody has named.
  bool apply(const SelectionChange& change, const ObjectTable& objects, const MechanismTable& mechanisms);
  void select_all() { *this = {}; }
  /// Takes up that the slot's object was removed: the next one in the slot is on.
  void forget(std::uint32_t slot);
  bool is_on(const ObjectTable& objects, std::uint32_t a, std::uint32_t b) const;

  /// apply() then does not allocate while no more than kPairRoom pairs are off by themselves.
  void reserve(std::size_t objects) {
    reserve_more(objects_off_, objects);
    pairs_off_.reserve(std::min(kPairRoom, objects * objects / 2));
  }
  static constexpr std::size_t kPairRoom = 65536;

 private:
  bool everything_ = true;
  std::uint64_t groups_off_ = 0;
  std::vector<std::uint32_t> objects_off_;                          // slots, sorted
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_off_;  // slots, sorted, first < second
};

}  // namespace touchstone
