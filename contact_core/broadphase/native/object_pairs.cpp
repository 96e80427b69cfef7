#include "touchstone/contact_core/broadphase/native/object_pairs.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace touchstone {

ObjectPairs::ObjectPairs(const SolidBounds& bounds, const ObjectForest& forest, TaskRunner* threads)
    : bounds_(bounds), forest_(forest), threads_(threads) {
  work_.reserve(kMostWork), work_scratch_.reserve(kMostWork);
  make_room(bounds.objects());
}

/// And for as many again, which come one by one.
void ObjectPairs::make_room(std::uint32_t objects) {
  forget();
  const std::size_t room = std::size_t{2} * objects;
  list_.reserve(room);
  is_changed_.reserve(room);
  changed_.reserve(room / kFew + 1), place_keys_.reserve(room / kFew + 1);
  fresh_.reserve(std::max<std::size_t>(room, 64));
  row_.reserve(room);
  marks_.resize(room / 64 + 1);
  listed_objects_ = room;
  set_count(objects);
}

void ObjectPairs::set_count(std::uint32_t objects) {
  list_.set_objects(objects);
  is_changed_.resize(objects);
}

void ObjectPairs::set_object(std::uint32_t object) {
  if (object >= listed_objects_)
    make_room(object + 1);
  else if (object >= is_changed_.size())
    set_count(object + 1);
  forget(std::span(&object, 1));
}

void ObjectPairs::forget(std::span<const std::uint32_t> moved) noexcept {
  start_frame();
  note_changes(moved);
}

void ObjectPairs::note_changes(std::span<const std::uint32_t> moved) noexcept {
  if (moved.empty()) return;
  if (state_ == State::full) state_ = State::due;
  if (state_ == State::due) return;
  state_ = State::few_changed;
  for (std::uint32_t object : moved) {
    if (is_changed_[object] != 0) continue;
    if (changed_.size() >= bounds_.objects() / kFew) {
      forget_changes();
      state_ = State::due;
      return;
    }
    is_changed_[object] = 1;
    changed_.push_back(object);
  }
}

void ObjectPairs::forget_changes() noexcept {
  for (std::uint32_t object : changed_) is_changed_[object] = 0;
  changed_.clear();
}

void ObjectPairs::make_list() noexcept {
  if (state_ == State::few_changed && list_changed_pairs()) return;
  forget_changes();
  state_ = list_all_pairs() ? State::complete : State::full;
}

// Only the pairs of objects that moved: each is asked for its partners.
bool ObjectPairs::list_changed_pairs() noexcept {
  fresh_.clear();
  forest_.sort_by_place(changed_, place_keys_);
  const bool fits = forest_.for_each_pair_of(changed_, [&](std::uint32_t object, std::uint32_t other) {
    if (is_changed_[other] != 0 && other <= object) return true;  // found from the other side
    if (fresh_.size() == fresh_.capacity()) return false;
    fresh_.push_back(object < other ? SolidPair{object, other} : SolidPair{other, object});
    return true;
  });
  if (!fits) return false;
  std::sort(fresh_.begin(), fresh_.end());
  if (!list_.replace(is_changed_, fresh_)) return false;
  forget_changes();
  state_ = State::complete;
  return true;
}

// False when the list does not hold all pairs.
bool ObjectPairs::list_all_pairs() noexcept {
  const ObjectGrid* const grid = forest_.grid();
  list_.start();
  if (!(grid != nullptr ? list_from_grid(*grid) : list_from_trees())) return false;
  list_.sort(threads_);
  return true;
}

bool ObjectPairs::list_from_grid(const ObjectGrid& grid) noexcept {
  const std::size_t tasks = threads_ == nullptr ? 1 : std::min(threads_->threads(), PairList::kMostWriters);
  std::atomic<std::size_t> next_part{0};
  std::atomic<bool> fits{true};
  auto task = [&](std::size_t) {
    PairList::Writer writer(list_);
    for (std::size_t part; (part = next_part.fetch_add(1, std::memory_order_relaxed)) < grid.parts();)
      grid.list_part(part, bounds_, writer);
    if (writer.is_full()) fits.store(false, std::memory_order_relaxed);
    writer.close();
  };
  run_tasks(threads_, tasks, task);
  return fits.load();
}

// Parts are the same on any number of threads, and so is the order within each.
bool ObjectPairs::append_by_place(std::vector<SolidPair>& out) noexcept {
  const ObjectGrid* const grid = forest_.grid();
  if (grid == nullptr || !bounds_.are_single()) return false;  // objects' numbers would not be solids'
  list_.start();
  std::atomic<bool> fits{true};
  auto task = [&](std::size_t part) {
    PairList::Writer writer(list_, part);
    grid->list_part(part, bounds_, writer);
    if (writer.is_full()) fits.store(false, std::memory_order_relaxed);
    writer.close();
  };
  run_tasks(threads_, grid->parts(), task);
  if (fits.load()) list_.append_found(out);
  return fits.load();
}

// Walking the trees, which is kind to caches.
bool ObjectPairs::list_from_trees() noexcept {
  const std::size_t tasks = threads_ == nullptr ? 1 : std::min(threads_->threads(), PairList::kMostWriters);
  work_.clear();
  for (int tree = 0; tree < ObjectForest::kTrees; ++tree) work_.push_back({tree, join_with(tree).root()});
  if (tasks > 1) split_work();
  std::atomic<std::size_t> next_work{0};
  std::atomic<bool> fits{true};
  auto task = [&](std::size_t) {
    PairList::Writer writer(list_);
    for (std::size_t i; (i = next_work.fetch_add(1, std::memory_order_relaxed)) < work_.size();)
      if (!list_pairs_below(work_[i], writer)) fits.store(false, std::memory_order_relaxed);
    writer.close();
  };
  run_tasks(threads_, tasks, task);
  return fits.load();
}

// Into parts of a size that keeps all threads busy to the end.
void ObjectPairs::split_work() noexcept {
  for (bool splits = true; splits && work_.size() * 16 <= kMostWork;) {
    splits = false;
    work_scratch_.clear();
    for (const Work& work : work_) {
      if (TreeJoin::is_leaf(work.nodes)) {
        work_scratch_.push_back(work);
        continue;
      }
      splits = true;
      join_with(work.tree).expand(work.nodes, [&](const NodePair& nodes) {
        work_scratch_.push_back({work.tree, nodes});
      });
    }
    work_.swap(work_scratch_);
  }
}

bool ObjectPairs::list_pairs_below(const Work& work, PairList::Writer& writer) const noexcept {
  const ObjectTree& moving = forest_.tree(ObjectForest::kMoving);
  const ObjectTree& partners = forest_.tree(work.tree);
  if (bounds_.on_paths())
    return list_pairs_below(work, writer, [&](std::uint32_t slot, std::uint32_t other) {
      return bounds_.paths_may_pair(moving.object_at(slot), partners.object_at(other));
    });
  return list_pairs_below(work, writer, [&](std::uint32_t slot, std::uint32_t other) {
    return may_touch(forest_.sphere_at(ObjectForest::kMoving, slot), forest_.sphere_at(work.tree, other),
                     bounds_.margin());
  });
}

template <class MayPair>
bool ObjectPairs::list_pairs_below(const Work& work, PairList::Writer& writer,
                                   MayPair may_pair) const noexcept {
  const ObjectTree& moving = forest_.tree(ObjectForest::kMoving);
  const ObjectTree& partners = forest_.tree(work.tree);
  const TreeJoin join = join_with(work.tree);
  join.walk(work.nodes, [&](const NodePair& leaf) {
    join.visit_leaf(leaf, [&](std::uint32_t slot, std::uint32_t other) {
      writer.add(moving.object_at(slot), partners.object_at(other), may_pair(slot, other));
    });
    return !writer.is_full();
  });
  return !writer.is_full();
}

std::span<const std::uint32_t> ObjectPairs::row(std::uint32_t object) noexcept {
  if (gathered_ == object) return row_;
  if (state_ == State::due || state_ == State::few_changed) {
    if (rows_asked_ < bounds_.objects() / kRowsAskedFirst)
      ++rows_asked_;
    else
      make_list();
  }
  gathered_ = object;
  row_.clear();
  if (state_ == State::complete) {
    copy_row(object);
  } else {
    ask_for_row(object);
  }
  return row_;
}

// Where many objects are partners, all are tried: in order, which saves the tree's walk and sorting.
void ObjectPairs::ask_for_row(std::uint32_t object) noexcept {
  const std::uint32_t objects = bounds_.objects();
  if (is_crowded_ && !bounds_.is_gone(object)) {
    const bool is_static = bounds_.is_static(object);
    for (std::uint32_t other = object + 1; other < objects; ++other)
      if (!(is_static && bounds_.is_static(other)) && !bounds_.is_gone(other) &&
          bounds_.may_pair(object, other))
        row_.push_back(other);
  } else {
    forest_.for_each_partner(object, object + 1, [&](std::uint32_t other) {
      row_.push_back(other);
      return true;
    });
    sort_row();
  }
  // Of objects of several solids the trees know tighter boxes.
  is_crowded_ = bounds_.solids() == objects && row_.size() > (objects - object) / kCrowdedShare;
}

// A row of a crowd is sorted by marking its objects: that costs a step each and one for 64 objects between.
void ObjectPairs::sort_row() noexcept {
  if (row_.size() < kMarkedRow || row_.size() < bounds_.objects() / 256) {
    std::sort(row_.begin(), row_.end());
    return;
  }
  std::uint32_t first = row_.front(), last = first;
  for (const std::uint32_t other : row_) {
    marks_[other / 64] |= std::uint64_t{1} << other % 64;
    first = std::min(first, other), last = std::max(last, other);
  }
  std::size_t next = 0;
  for (std::uint32_t word = first / 64; word <= last / 64; ++word) {
    for (std::uint64_t left = std::exchange(marks_[word], 0); left != 0; left &= left - 1)
      row_[next++] = 64 * word + static_cast<std::uint32_t>(std::countr_zero(left));
  }
}

// Rows are read in order: the next one begins where the last one ended.
void ObjectPairs::copy_row(std::uint32_t object) noexcept {
  const std::span<const SolidPair> pairs = list_.pairs();
  std::size_t next = row_end_;
  const bool follows = next <= pairs.size() && (next == 0 || pairs[next - 1].a < object) &&
                       (next == pairs.size() || pairs[next].a >= object);
  if (!follows)
    next = static_cast<std::size_t>(std::lower_bound(pairs.begin(), pairs.end(), SolidPair{object, 0}) -
                                    pairs.begin());
  for (; next < pairs.size() && pairs[next].a == object; ++next) row_.push_back(pairs[next].b);
  row_end_ = next;
}

}  // namespace touchstone
