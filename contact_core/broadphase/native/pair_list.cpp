#include "touchstone/contact_core/broadphase/native/pair_list.hpp"

#include <cstring>

namespace touchstone {
namespace {

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

/// Pairs of one lower object, at most this many.
constexpr std::uint32_t kShort = 4;

/// The same of these, without a branch, which none could predict: what follows the row stays as it is.
/// @pre kShort pairs may be read and written there.
void sort_short_row(SolidPair* row, std::uint32_t count) {
  // Bits, all of them or none, say which is less: of conditions, compilers make branches.
  const auto all_if = [](bool is_so) { return ~(std::uint32_t{is_so} - 1); };
  std::array<std::uint32_t, kShort> b, sorted, beyond;
  for (std::uint32_t i = 0; i < kShort; ++i) {
    beyond[i] = all_if(i >= count);
    b[i] = row[i].b;
    sorted[i] = b[i] | beyond[i];
  }
  for (const auto& [i, j] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}}) {
    const std::uint32_t swapped = (sorted[i] ^ sorted[j]) & all_if(sorted[j] < sorted[i]);
    sorted[i] ^= swapped, sorted[j] ^= swapped;
  }
  for (std::uint32_t i = 0; i < kShort; ++i) row[i].b = (sorted[i] & ~beyond[i]) | (b[i] & beyond[i]);
}

}  // namespace

std::uint32_t PairList::shift_for(std::size_t objects) {
  std::uint32_t shift = kLeastShift;
  while (objects >> shift >= kMostHeaps) ++shift;
  return shift;
}

// A block of each heap may stay unused in part: of all writers' heaps, or of the parts' heaps.
std::size_t PairList::blocks_for(std::size_t objects) {
  const std::size_t heaps = std::min(kMostHeaps, (objects >> kLeastShift) + 1);
  return objects * kPairsPerObject / kBlock + std::max(kMostHeaps, kMostWriters * heaps) + 1;
}

void PairList::reserve(std::size_t objects) {
  count_ = 0;
  start();
  const std::size_t blocks = blocks_for(objects);
  const std::size_t bytes = GrowingMemory::bytes_of(blocks, kBlock * sizeof(SolidPair));
  for (GrowingMemory* memory : {&found_, &pairs_}) {
    memory->grow(0, bytes);
    std::memset(memory->data(), 0, kBlock * sizeof(SolidPair));  // its page is there for the first pairs
  }
  used_.reserve(blocks), block_below_.reserve(blocks);
  row_end_.reserve(objects);
}

void PairList::set_objects(std::uint32_t objects) {
  row_end_.resize(objects);
  shift_ = shift_for(objects);
  used_.resize(blocks_for(objects)), block_below_.resize(used_.size());
  capacity_ = used_.size() * kBlock;
}

void PairList::start() noexcept {
  next_block_ = 0;
  for (std::atomic<std::uint32_t>& top : top_) top.store(kNoIndex, std::memory_order_relaxed);
}

// A block that is left is full of pairs.
void PairList::Writer::open_block(std::uint32_t heap) noexcept {
  Place& place = places_[heap];
  const std::size_t block = list_.next_block_.fetch_add(1, std::memory_order_relaxed);
  if (block >= list_.used_.size()) {
    is_full_ = true;
    place = {&spare_, &spare_ + 1, kNoIndex};
    return;
  }
  place.block = static_cast<std::uint32_t>(block);
  place.next = list_.found() + block * kBlock;
  place.end = place.next + kBlock;
  list_.used_[block] = kBlock;
  list_.block_below_[block] = list_.top_[heap].exchange(place.block, std::memory_order_relaxed);
}

void PairList::Writer::close() noexcept {
  for (Place& place : places_) {
    if (place.block != kNoIndex)
      list_.used_[place.block] =
          static_cast<std::uint32_t>(kBlock - static_cast<std::size_t>(place.end - place.next));
    place = {};
  }
}

template <class Visit>
void PairList::for_each_found(std::size_t heap, Visit visit) const noexcept {
  for (std::uint32_t block = top_[heap]; block != kNoIndex; block = block_below_[block])
    for (std::uint32_t i = 0; i < used_[block]; ++i) visit(found()[block * kBlock + i]);
}

std::size_t PairList::count_in(std::size_t heap) const noexcept {
  std::size_t count = 0;
  for (std::uint32_t block = top_[heap]; block != kNoIndex; block = block_below_[block])
    count += used_[block];
  return count;
}

void PairList::sort(TaskRunner* threads) noexcept {
  const std::size_t heaps = (row_end_.size() >> shift_) + 1;
  std::array<std::size_t, kMostHeaps + 1> first_pair{};
  for (std::size_t heap = 0; heap < heaps; ++heap) first_pair[heap + 1] = first_pair[heap] + count_in(heap);
  count_ = first_pair[heaps];
  auto sort_one = [&](std::size_t heap) { sort_heap(heap, first_pair[heap]); };
  run_tasks(threads, heaps, sort_one);
}

// By counting into rows, one a lower object.
void PairList::sort_heap(std::size_t heap, std::size_t first_pair) noexcept {
  const std::size_t first = heap << shift_, last = std::min(row_end_.size(), (heap + 1) << shift_);
  std::fill(row_end_.begin() + first, row_end_.begin() + last, 0u);
  for_each_found(heap, [&](const SolidPair& pair) { ++row_end_[pair.a]; });
  // Sums say where rows begin, and filling them moves that to their ends.
  auto start = static_cast<std::uint32_t>(first_pair);
  for (std::size_t row = first; row < last; ++row) {
    const std::uint32_t pairs = row_end_[row];
    row_end_[row] = start;
    start += pairs;
  }
  for_each_found(heap, [&](const SolidPair& pair) { sorted()[row_end_[pair.a]++] = pair; });
  // Then each row is sorted.
  auto row_first = static_cast<std::uint32_t>(first_pair);
  const std::uint32_t end = start;
  for (std::size_t row = first; row < last; ++row) {
    const std::uint32_t count = row_end_[row] - row_first;
    if (count <= kShort && row_first + kShort <= end)
      sort_short_row(sorted() + row_first, count);
    else
      sort_row(sorted() + row_first, sorted() + row_end_[row]);
    row_first = row_end_[row];
  }
}

// The block that was written last lies on top.
void PairList::append_found(std::vector<SolidPair>& out) const noexcept {
  for (std::size_t heap = 0; heap < kMostHeaps; ++heap) {
    std::size_t end = out.size() + count_in(heap);
    out.resize(end);
    for (std::uint32_t block = top_[heap]; block != kNoIndex; block = block_below_[block]) {
      end -= used_[block];
      std::copy_n(found() + block * kBlock, used_[block], out.begin() + static_cast<std::ptrdiff_t>(end));
    }
  }
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
