#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace touchstone {

/// What is switched on or off: everything, an object, a pair of objects, or a group. A pair is checked while
/// all that it belongs to is on.
struct SelectionChange {
  /// What `first` and `second` name: nothing, an object, two objects, a group.
  enum class Scope : std::uint8_t { everything, object, pair, group };

  Scope scope = Scope::everything;
  std::uint32_t first = 0;   ///< object slot, or group index
  std::uint32_t second = 0;  ///< the pair's other object slot
  bool on = true;

  friend bool operator==(const SelectionChange&, const SelectionChange&) = default;
};

/// A change that came into force, for a replay.
struct SelectionRecord {
  std::uint64_t frame;  ///< the frame at whose start it came into force
  SelectionChange change;
};

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

  /// Drops what waits for an object that is gone: its slot may be another's by the next frame.
  void forget(std::uint32_t slot) {
    const std::lock_guard lock(mutex_);
    std::erase_if(waiting_, [slot](const SelectionChange& change) {
      const bool is_pair = change.scope == SelectionChange::Scope::pair;
      return (is_pair && change.second == slot) ||
             ((is_pair || change.scope == SelectionChange::Scope::object) && change.first == slot);
    });
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

}  // namespace touchstone
