#include "touchstone/contact_core/broadphase/native/morton_sort.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

/// Of fewer that share a cell the order does not matter.
constexpr std::uint32_t kCrowd = 16;

/// As many are put in order in less time than the digits' tables take to begin with.
constexpr std::uint32_t kFewToSort = 32;

// Interleaves the low 10 bits with two zeros between each.
std::uint32_t spread_bits(std::uint32_t v) {
  v = (v | (v << 16)) & 0x030000FF;
  v = (v | (v << 8)) & 0x0300F00F;
  v = (v | (v << 4)) & 0x030C30C3;
  return (v | (v << 2)) & 0x09249249;
}

std::uint32_t morton_key(const Vector3& p, const Vector3& low, const Vector3& cells_per_metre) {
  std::uint32_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const double cell = (p(i) - low(i)) * cells_per_metre(i);
    key |= spread_bits(cell > 0.0 ? static_cast<std::uint32_t>(std::min(cell, 1023.0)) : 0u) << i;
  }
  return key;
}

}  // namespace

void MortonSort::reserve(std::size_t objects) {
  if (objects <= keys_.size()) return;
  reserve_more(ranges_, objects / kCrowd + 1);
  // The keys come last, as their number says what there is room for.
  for (GrowingList<std::uint32_t>* list : {&keys_scratch_, &order_scratch_, &keys_})
    resize_more(*list, objects);
}

void MortonSort::begin(std::uint32_t count) noexcept {
  count_ = count;
  frame_ = {};
  ranges_.clear();
  range_ = {0, count};
  is_whole_ = true;
  begin_range();
}

bool MortonSort::is_few() const noexcept { return range_.last - range_.first <= kFewToSort; }

void MortonSort::begin_range() noexcept {
  stage_ = Stage::bounds;
  at_ = range_.first;
  low_ = Vector3::Constant(kInfinity), high_ = Vector3::Constant(-kInfinity);
}

// Morton order within the range's own bounds. Objects that share a cell are sorted again within theirs, so
// that a crowd far smaller than the scene is resolved as well. A level zooms in by 1023: doubles end it.
bool MortonSort::go_on(std::span<const Sphere> spheres, std::span<std::uint32_t> order,
                       std::size_t& work) noexcept {
  for (;;) {
    // A step does as much of its stage as the work allows.
    const auto end = static_cast<std::uint32_t>(at_ + std::min<std::size_t>(work, range_.last - at_));
    if (work != kAll) work -= end - at_;
    bool is_ordered = false;
    // The stages are bounds, keys, sorting by digits and runs of equal keys.
    if (stage_ == Stage::bounds) {
      find_bounds(spheres, order, end);
      if (at_ == range_.last) is_ordered = !begin_keys();
    } else if (stage_ == Stage::keys) {
      find_keys(spheres, order, end);
      if (at_ == range_.last && is_few())
        insert_all(order), begin_runs();
      else if (at_ == range_.last)
        digit_ = 0, begin_scatter();
    } else if (stage_ == Stage::scatter) {
      scatter(order, end);
      if (at_ == range_.last && ++digit_ < kDigits)
        begin_scatter();
      else if (at_ == range_.last)
        begin_runs();
    } else {
      find_runs(order, end);
      is_ordered = at_ == range_.last;
    }
    // The next range begins when one is ordered.
    if (is_ordered && ranges_.empty()) break;
    if (is_ordered) range_ = ranges_.back(), ranges_.pop_back(), is_whole_ = false, begin_range();
    if (work == 0) return false;
  }
  // Floats are finest about their origin: put it where objects are, whatever strays.
  const Vector3 middle = count_ > 0 ? spheres[order[count_ / 2]].centre : Vector3::Zero();
  if (is_finite(middle)) frame_.origin = middle;
  return true;
}

/// Objects that are near each other are anywhere in memory.
void MortonSort::fetch_ahead(std::span<const Sphere> spheres,
                             std::span<const std::uint32_t> order) const noexcept {
  constexpr std::uint32_t kAhead = 16;
  if (at_ + kAhead < range_.last) __builtin_prefetch(&spheres[order[at_ + kAhead]]);
}

void MortonSort::find_bounds(std::span<const Sphere> spheres, std::span<const std::uint32_t> order,
                             std::uint32_t end) noexcept {
  for (; at_ < end; ++at_) {
    fetch_ahead(spheres, order);
    const Vector3& c = spheres[order[at_]].centre;
    if (is_finite(c)) low_ = low_.cwiseMin(c), high_ = high_.cwiseMax(c);
  }
}

/// @returns false: all stand in one place.
bool MortonSort::begin_keys() noexcept {
  cells_per_metre_ = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double per_metre = 1023.0 / (high_(i) - low_(i));
    const bool usable = std::isfinite(low_(i)) && std::isfinite(per_metre) && per_metre > 0.0;
    if (usable) cells_per_metre_(i) = per_metre;
    if (usable && is_whole_) frame_.scale(i) = per_metre;
  }
  stage_ = Stage::keys;
  at_ = range_.first;
  if (!is_few())
    for (auto& start : start_) start.fill(0);
  return cells_per_metre_ != Vector3::Zero();
}

void MortonSort::find_keys(std::span<const Sphere> spheres, std::span<const std::uint32_t> order,
                           std::uint32_t end) noexcept {
  for (; at_ < end; ++at_) {
    fetch_ahead(spheres, order);
    const std::uint32_t key = morton_key(spheres[order[at_]].centre, low_, cells_per_metre_);
    keys_[at_] = key;
    if (is_few()) continue;
    for (int digit = 0; digit < kDigits; ++digit)
      ++start_[digit][key >> digit * kDigitBits & (kDigitValues - 1)];
  }
}

void MortonSort::begin_scatter() noexcept {
  stage_ = Stage::scatter;
  at_ = range_.first;
  auto& start = start_[digit_];
  std::exclusive_scan(start.begin(), start.end(), start.begin(), range_.first);
}

/// By one digit, from one pair of lists to the other.
void MortonSort::scatter(std::span<std::uint32_t> order, std::uint32_t end) noexcept {
  std::span<std::uint32_t> keys = keys_, next_keys = keys_scratch_, next = order_scratch_;
  if (digit_ % 2 != 0) std::swap(keys, next_keys), std::swap(order, next);
  for (; at_ < end; ++at_) {
    const std::uint32_t place = start_[digit_][keys[at_] >> digit_ * kDigitBits & (kDigitValues - 1)]++;
    next_keys[place] = keys[at_], next[place] = order[at_];
  }
}

/// Into the scratch lists; equal keys keep their order, as where digits are counted.
void MortonSort::insert_all(std::span<const std::uint32_t> order) noexcept {
  for (std::uint32_t i = range_.first; i < range_.last; ++i) {
    std::uint32_t place = i;
    for (; place > range_.first && keys_scratch_[place - 1] > keys_[i]; --place) {
      keys_scratch_[place] = keys_scratch_[place - 1];
      order_scratch_[place] = order_scratch_[place - 1];
    }
    keys_scratch_[place] = keys_[i], order_scratch_[place] = order[i];
  }
}

void MortonSort::begin_runs() noexcept {
  stage_ = Stage::runs;
  at_ = run_ = range_.first;
}

/// All stand in the scratch lists, in order.
void MortonSort::find_runs(std::span<std::uint32_t> order, std::uint32_t end) noexcept {
  for (; at_ < end; ++at_) {
    order[at_] = order_scratch_[at_];
    if (keys_scratch_[at_] != keys_scratch_[run_]) note_run(at_);
  }
  if (at_ == range_.last && at_ > range_.first) note_run(at_);
}

void MortonSort::note_run(std::uint32_t end) noexcept {
  if (end - run_ > kCrowd) ranges_.push_back({run_, end});
  run_ = end;
}

}  // namespace touchstone
