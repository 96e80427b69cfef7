#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/threads/task_runner.hpp"

namespace touchstone {

/// Pairs of objects, a < b, found in any order on any threads, then in ascending order. All memory is taken
/// in reserve(), and left untouched until pairs need it, so that an ample capacity costs address space only.
class PairList {
 public:
  static constexpr std::size_t kMostWriters = 16;

  /// Cold. Makes room for up to `objects` objects; holds no pairs.
  void reserve(std::size_t objects);
  /// Sets the number of pairs. @pre reserve() of at least as many.
  void set_objects(std::uint32_t objects);

  /// Forgets all pairs.
  void start() noexcept { next_block_ = 0; }

  /// One thread's access. Pairs count from the next room() or close() on.
  class Writer {
   public:
    explicit Writer(PairList& list) : list_(list) {}

    static constexpr std::size_t kRoom = 16;
    /// Makes room for kRoom pairs; false when the list is full.
    bool room() noexcept { return static_cast<std::size_t>(end_ - next_) >= kRoom || open_block(); }
    /// Writes a pair, which stays if `keep`: no branch, which none could predict.
    void add(std::uint32_t a, std::uint32_t b, bool keep) noexcept {
      *next_ = a < b ? SolidPair{a, b} : SolidPair{b, a};
      next_ += keep ? 1 : 0;
    }
    void close() noexcept;

   private:
    bool open_block() noexcept;

    PairList& list_;
    std::size_t block_ = 0;
    SolidPair* next_ = nullptr;
    SolidPair* end_ = nullptr;
  };

  /// Puts what the writers left in ascending order.
  void sort(TaskRunner* threads) noexcept;

  /// Drops the pairs of every object with `changed` set and adds `fresh`, which is ascending and holds none
  /// of the others. False, and nothing changed, when there is no room.
  bool replace(std::span<const std::uint8_t> changed, std::span<const SolidPair> fresh) noexcept;

  std::span<const SolidPair> pairs() const { return {sorted(), count_}; }

 private:
  static constexpr std::size_t kBlock = 1024;
  // Scenes so dense that the list does not hold their pairs are asked row by row: there the answer is most of
  // the work.
  static constexpr std::size_t kPairsPerObject = 64;

  static std::size_t blocks_for(std::size_t objects);

  SolidPair* found() const { return static_cast<SolidPair*>(found_.data()); }
  SolidPair* sorted() const { return static_cast<SolidPair*>(pairs_.data()); }

  template <class Visit>
  void for_each_found(Visit visit) const noexcept;
  std::uint32_t first_row(std::size_t task, std::size_t tasks) const noexcept;

  GrowingMemory found_{alignof(SolidPair)}, pairs_{alignof(SolidPair)};
  std::size_t capacity_ = 0;             ///< of each
  std::size_t count_ = 0;                ///< in pairs_
  GrowingList<std::uint32_t> used_;      ///< of each block of found_
  std::atomic<std::size_t> next_block_;  ///< and beyond the last when the list is full
  GrowingList<std::uint32_t> row_end_;   ///< of the pairs of each lower object, in pairs_
};

}  // namespace touchstone
