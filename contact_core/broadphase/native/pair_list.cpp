#include "touchstone/contact_core/broadphase/native/pair_list.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace touchstone {
namespace {

constexpr std::size_t kMostSortTasks = 16;

// Most rows have a few pairs only.
void sort_row(SolidPair* first, SolidPair* last) {
  if (last - first > 24) {
    std::sort(first, last);
    return;
  }
  for (SolidPair* unsorted = first; unsorted < last; ++unsorted) {
    const SolidPair pair = *unsorted;
    SolidPair* hole = unsorted;
    for (; hole > first && pair.b < hole[-1].b; --hole) *hole = hole[-1];
    *hole = pair;
  }
}

}  // namespace

// The last few places of a block may stay unused.
std::size_t PairList::blocks_for(std::size_t objects) {
  return objects * kPairsPerObject / (kBlock - Writer::kRoom) + 1 + kMostWriters;
}

void PairList::reserve(std::size_t objects) {
  count_ = 0;
  next_block_ = 0;
  const std::size_t blocks = blocks_for(objects);
  const std::size_t bytes = GrowingMemory::bytes_of(blocks, kBlock * sizeof(SolidPair));
  for (GrowingMemory* memory : {&found_, &pairs_}) memory->grow(0, bytes);
  used_.reserve(blocks);
  row_end_.reserve(objects);
}

void PairList::set_objects(std::uint32_t objects) {
  row_end_.resize(objects);
  used_.resize(blocks_for(objects));
  capacity_ = used_.size() * kBlock;
}

bool PairList::Writer::open_block() noexcept {
  close();
  block_ = list_.next_block_.fetch_add(1, std::memory_order_relaxed);
  if (block_ >= list_.used_.size()) return false;
  next_ = &list_.found()[block_ * kBlock];
  end_ = next_ + kBlock;
  return true;
}

void PairList::Writer::close() noexcept {
  if (next_ != nullptr)
    list_.used_[block_] = static_cast<std::uint32_t>(next_ - &list_.found()[block_ * kBlock]);
  next_ = end_ = nullptr;
}

template <class Visit>
void PairList::for_each_found(Visit visit) const noexcept {
  const std::size_t blocks = std::min<std::size_t>(next_block_, used_.size());
  for (std::size_t block = 0; block < blocks; ++block)
    for (std::uint32_t i = 0; i < used_[block]; ++i) visit(found()[block * kBlock + i]);
}

// Of evenly spread pairs, (1 - x)^2 have their lower object beyond a share x of the objects: so the tasks get
// equal shares of the pairs.
std::uint32_t PairList::first_row(std::size_t task, std::size_t tasks) const noexcept {
  if (task >= tasks) return static_cast<std::uint32_t>(row_end_.size());
  const double share = static_cast<double>(tasks - task) / static_cast<double>(tasks);
  return static_cast<std::uint32_t>(static_cast<double>(row_end_.size()) * (1.0 - std::sqrt(share)));
}

// By counting into rows, one a lower object: each task reads all that was found and writes its own rows.
void PairList::sort(TaskRunner* threads) noexcept {
  const std::size_t tasks = threads == nullptr ? 1 : std::min(threads->threads(), kMostSortTasks);
  std::array<std::size_t, kMostSortTasks + 1> first_pair{};
  // Each task counts its rows.
  auto count = [&](std::size_t task) {
    const std::uint32_t first = first_row(task, tasks), last = first_row(task + 1, tasks);
    std::fill(row_end_.begin() + first, row_end_.begin() + last, 0u);
    std::size_t pairs = 0;
    for_each_found([&](const SolidPair& pair) {
      if (pair.a - first < last - first) ++row_end_[pair.a], ++pairs;
    });
    first_pair[task + 1] = pairs;
  };
  run_tasks(threads, tasks, count);
  // Sums say where each task's rows begin.
  for (std::size_t task = 0; task < tasks; ++task) first_pair[task + 1] += first_pair[task];
  count_ = first_pair[tasks];
  // Each task fills its rows, then sorts each of them.
  auto place = [&](std::size_t task) {
    const std::uint32_t first = first_row(task, tasks), last = first_row(task + 1, tasks);
    auto start = static_cast<std::uint32_t>(first_pair[task]);
    for (std::uint32_t row = first; row < last; ++row) {
      const std::uint32_t pairs = row_end_[row];
      row_end_[row] = start;
      start += pairs;
    }
    for_each_found([&](const SolidPair& pair) {
      if (pair.a - first < last - first) sorted()[row_end_[pair.a]++] = pair;
    });
    auto row_first = static_cast<std::uint32_t>(first_pair[task]);
    for (std::uint32_t row = first; row < last; ++row) {
      sort_row(sorted() + row_first, sorted() + row_end_[row]);
      row_first = row_end_[row];
    }
  };
  run_tasks(threads, tasks, place);
}

bool PairList::replace(std::span<const std::uint8_t> changed, std::span<const SolidPair> fresh) noexcept {
  if (count_ + fresh.size() > capacity_) return false;
  auto next_fresh = fresh.begin();
  SolidPair* out = found();
  for (const SolidPair& old : pairs()) {
    if ((changed[old.a] | changed[old.b]) != 0) continue;
    while (next_fresh != fresh.end() && *next_fresh < old) *out++ = *next_fresh++;
    *out++ = old;
  }
  out = std::copy(next_fresh, fresh.end(), out);
  count_ = static_cast<std::size_t>(out - found());
  std::swap(found_, pairs_);
  return true;
}

}  // namespace touchstone
