#pragma once

#include "touchstone/contact_core/broadphase/native/object_forest.hpp"
#include "touchstone/contact_core/broadphase/native/pair_list.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// The pairs of objects that may touch, row by row: a row is an object and its partners above it. The first
/// few rows of a frame are found in the forest one by one, since a caller that stops early needs no more;
/// then all pairs are listed at once. The list is kept while few objects move.
class ObjectPairs {
 public:
  /// Cold. Keeps `bounds` and `forest`, and `threads`, which may be null.
  ObjectPairs(const SolidBounds& bounds, const ObjectForest& forest, TaskRunner* threads);

  /// An object was added, replaced or removed.
  void set_object(std::uint32_t object);

  /// All objects were placed anew.
  void forget() noexcept { state_ = State::due, start_frame(); }
  /// These objects were placed anew.
  void forget(std::span<const std::uint32_t> moved) noexcept;

  /// The partners above `object`, ascending; the span is good until the next call.
  std::span<const std::uint32_t> row(std::uint32_t object) noexcept;

  /// All pairs, ascending, if they are listed by now; else nothing, and rows must be asked for.
  bool is_listed() const { return state_ == State::complete; }

  /// Appends all pairs in an order of places: those of an object stand together, and objects that are near.
  /// False, and appends nothing: there is no grid that tells it, or no room.
  bool append_by_place(std::vector<SolidPair>& out) noexcept;
  std::span<const SolidPair> listed() const { return list_.pairs(); }

 private:
  enum class State { due, few_changed, complete, full };
  struct Work {
    int tree;  // the moving objects with this one
    NodePair nodes;
  };

  void make_room(std::uint32_t objects);
  void set_count(std::uint32_t objects);
  void start_frame() noexcept { gathered_ = kNoIndex, rows_asked_ = 0, is_crowded_ = false; }
  void note_changes(std::span<const std::uint32_t> moved) noexcept;
  void forget_changes() noexcept;
  void make_list() noexcept;
  bool list_changed_pairs() noexcept;
  bool list_all_pairs() noexcept;
  bool list_from_grid(const ObjectGrid& grid) noexcept;
  bool list_from_trees() noexcept;
  void split_work() noexcept;
  bool list_pairs_below(const Work& work, PairList::Writer& writer) const noexcept;
  template <class MayPair>
  bool list_pairs_below(const Work& work, PairList::Writer& writer, MayPair may_pair) const noexcept;
  void copy_row(std::uint32_t object) noexcept;
  void ask_for_row(std::uint32_t object) noexcept;
  void sort_row() noexcept;
  TreeJoin join_with(int tree) const { return {forest_.tree(ObjectForest::kMoving), forest_.tree(tree)}; }

  static constexpr std::uint32_t kFew = ObjectForest::kFew;
  // Share of rows that are asked for one by one before the list is made: one in this many.
  static constexpr std::uint32_t kRowsAskedFirst = 1024;
  static constexpr std::size_t kMostWork = 4096;
  // Of the objects after it: from one partner in this many on, trying all is quicker.
  static constexpr std::uint32_t kCrowdedShare = 8;
  static constexpr std::size_t kMarkedRow = 32;  // of fewer, sorting costs less

  const SolidBounds& bounds_;
  const ObjectForest& forest_;
  TaskRunner* threads_;
  State state_ = State::due;
  PairList list_;
  std::size_t listed_objects_ = 0;  // that list_ has room for
  std::vector<Work> work_, work_scratch_;
  GrowingList<std::uint8_t> is_changed_;  // since the list was made, by object
  std::vector<std::uint32_t> changed_;
  std::vector<std::uint64_t> place_keys_;
  std::vector<SolidPair> fresh_;
  std::uint32_t rows_asked_ = 0;
  bool is_crowded_ = false;  // in the last row that was asked for by itself, most objects were partners
  std::uint32_t gathered_ = kNoIndex;  // the row in row_
  std::vector<std::uint32_t> row_;
  GrowingList<std::uint64_t> marks_;  // a bit an object, all 0 between rows
  std::size_t row_end_ = 0;           // of the row of list_ read last
};

}  // namespace touchstone
