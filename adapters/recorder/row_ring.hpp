#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/output/frame_output.hpp"

// Private to this folder.

namespace touchstone::recorder {

/// One line of a record on its way: what differs by kind shares its place. A frame is a `frame` row and the
/// `rows` that follow it.
struct Row {
  enum class Kind : std::uint8_t { frame, pose, event };

  Kind kind = Kind::frame;
  EventKind event = EventKind::near;
  ObjectHandle a, b;  ///< a pose's object; an event's two
  SolidPair solids;
  std::uint64_t frame = 0;
  std::uint32_t part = 0;  ///< an event's
  std::uint64_t lost = 0;  ///< frame: dropped since the one before
  std::uint32_t rows = 0;  ///< frame: how many follow
  /// frame: time. pose: R row by row, then p. event: s, then separation, n, p_A, p_B there, and at the
  /// frame's end.
  std::array<double, 21> values{};
};

/// Rows from one thread to one other, without locks; their number is fixed.
class RowRing {
 public:
  explicit RowRing(std::size_t rows) : rows_(std::bit_ceil(rows)) {}

  std::size_t size() const { return rows_.size(); }

  // ---- the thread that writes
  std::size_t room() const { return rows_.size() - (head_ - tail_.load(std::memory_order_acquire)); }
  /// @pre i < room()
  Row& free_row(std::size_t i) { return rows_[(head_ + i) & (rows_.size() - 1)]; }
  void publish(std::size_t count) {
    head_ += count;
    published_.store(head_, std::memory_order_release);
  }
  void wait_for_more_room(std::size_t wanted) const {
    while (true) {
      const std::size_t tail = tail_.load(std::memory_order_acquire);
      if (rows_.size() - (head_ - tail) >= wanted) return;
      tail_.wait(tail, std::memory_order_acquire);
    }
  }

  // ---- the thread that reads
  std::size_t available() const {
    return published_.load(std::memory_order_acquire) - tail_.load(std::memory_order_relaxed);
  }
  /// @pre i < available()
  const Row& row(std::size_t i) const {
    return rows_[(tail_.load(std::memory_order_relaxed) + i) & (rows_.size() - 1)];
  }
  void release(std::size_t count) {
    tail_.fetch_add(count, std::memory_order_release);
    tail_.notify_one();
  }

 private:
  std::vector<Row> rows_;
  std::size_t head_ = 0;  // the writing thread's own
  alignas(64) std::atomic<std::size_t> published_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace touchstone::recorder
