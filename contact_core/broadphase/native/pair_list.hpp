#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/threads/task_runner.hpp"

namespace touchstone {

/// Pairs of objects, a < b, found in any order on any threads, then in ascending order. All memory is taken
/// in reserve(), and left untouched until pairs need it, so that an ample capacity costs address space only.
///
/// Pairs that are found are thrown on heaps: one for each run of lower objects, so that each is sorted within
/// the caches; or one for each part of the work, so that they can be read in the order of the parts.
class PairList {
 public:
  static constexpr std::size_t kMostWriters = 16;
  static constexpr std::size_t kMostHeaps = 128;

  /// Cold. Makes room for up to `objects` objects; holds no pairs.
  void reserve(std::size_t objects);
  /// Sets the number of objects. @pre reserve() of at least as many.
  void set_objects(std::uint32_t objects);

  /// Forgets what was found.
  void start() noexcept;

  /// One thread's access. Pairs count from close() on.
  class Writer {
   public:
    /// Throws pairs on the heaps of their lower objects. At most kMostWriters between start() and sort().
    explicit Writer(PairList& list) noexcept : list_(list), shift_(list.shift_) {}
    /// Throws all on one heap, below kMostHeaps, whose only writer it is.
    Writer(PairList& list, std::size_t heap) noexcept
        : list_(list), shift_(kAllBits), first_heap_(static_cast<std::uint32_t>(heap)) {}

    /// Writes a pair, which stays if `keep`: no branch that none could predict.
    void add(std::uint32_t a, std::uint32_t b, bool keep) noexcept {
      const std::uint64_t low = std::min(a, b);
      const auto heap = first_heap_ + static_cast<std::uint32_t>(low >> shift_);
      Place& place = places_[heap];
      if (place.next == place.end) open_block(heap);
      *place.next = {std::min(a, b), std::max(a, b)};
      place.next += keep ? 1 : 0;
    }
    /// Whether a pair found no room.
    bool is_full() const noexcept { return is_full_; }
    void close() noexcept;

   private:
    struct Place {
      SolidPair *next = nullptr, *end = nullptr;
      std::uint32_t block = kNoIndex;
    };
    static constexpr std::uint32_t kAllBits = 32;

    void open_block(std::uint32_t heap) noexcept;

    PairList& list_;
    std::uint32_t shift_, first_heap_ = 0;
    bool is_full_ = false;
    SolidPair spare_{};  // where pairs go that find no room
    std::array<Place, kMostHeaps> places_;
  };

  /// Puts what the writers left in ascending order.
  void sort(TaskRunner* threads) noexcept;

  /// Appends what the writers left, heap by heap, each heap as it was written; what sort() made stays.
  void append_found(std::vector<SolidPair>& out) const noexcept;

  /// Drops the pairs of every object with `changed` set and adds `fresh`, which is ascending and holds none
  /// of the others. False, and nothing changed, when there is no room.
  bool replace(std::span<const std::uint8_t> changed, std::span<const SolidPair> fresh) noexcept;

  std::span<const SolidPair> pairs() const { return {sorted(), count_}; }

  /// Scenes so dense that the list does not hold their pairs are asked row by row: there the answer is most
  /// of the work.
  static constexpr std::size_t kPairsPerObject = 64;

 private:
  static constexpr std::size_t kBlock = 512;
  // Objects a heap, or more: counters and pairs of a heap fit the second cache.
  static constexpr std::uint32_t kLeastShift = 13;

  static std::size_t blocks_for(std::size_t objects);
  static std::uint32_t shift_for(std::size_t objects);
  void sort_heap(std::size_t heap, std::size_t first_pair) noexcept;
  std::size_t count_in(std::size_t heap) const noexcept;

  SolidPair* found() const { return static_cast<SolidPair*>(found_.data()); }
  SolidPair* sorted() const { return static_cast<SolidPair*>(pairs_.data()); }

  template <class Visit>
  void for_each_found(std::size_t heap, Visit visit) const noexcept;

  GrowingMemory found_{alignof(SolidPair)}, pairs_{alignof(SolidPair)};
  std::size_t capacity_ = 0;                       ///< of each
  std::size_t count_ = 0;                          ///< in pairs_
  std::uint32_t shift_ = kLeastShift;              ///< from a lower object to its heap
  GrowingList<std::uint32_t> used_, block_below_;  ///< of each block of found_: pairs; next one of its heap
  std::array<std::atomic<std::uint32_t>, kMostHeaps> top_{};  ///< block of each heap, or kNoIndex
  std::atomic<std::size_t> next_block_{0};                    ///< and beyond the last when the list is full
  GrowingList<std::uint32_t> row_end_;  ///< of the pairs of each lower object, in pairs_
};

}  // namespace touchstone
