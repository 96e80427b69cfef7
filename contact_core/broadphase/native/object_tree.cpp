#include "touchstone/contact_core/broadphase/native/object_tree.hpp"

#include <cmath>
#include <numeric>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {
namespace {

template <class Lanes>
auto largest_lane(Lanes v) {
  return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
}

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

void ObjectTree::resize(std::vector<std::uint32_t> objects) {
  size_ = static_cast<std::uint32_t>(objects.size());
  order_ = std::move(objects);
  gone_.clear();
  order_scratch_.resize(order_.size()), keys_.resize(order_.size()), keys_scratch_.resize(order_.size());
  level_start_ = {0};
  auto count = static_cast<std::uint32_t>(order_.size());
  do {
    count = (count + kWidth - 1) / kWidth;
    level_start_.push_back(level_start_.back() + std::max(count, 1u));
  } while (count > 1);
  constexpr float kNone = std::numeric_limits<float>::infinity();
  const Floats low = {kNone, kNone, kNone, kNone};
  const Ints no_object = {-1, -1, -1, -1};
  nodes_.assign(level_start_.back(), {{low, low, low}, {-low, -low, -low}, no_object});
}

// An eighth more, and some: those that come stand in no order until the next sort(). All keep their slots.
void ObjectTree::make_room() {
  const std::uint32_t used = size_;
  std::vector<std::uint32_t> objects(order_.begin(), order_.begin() + used);
  objects.resize(used + used / 8 + 64, kNoObject);
  resize(std::move(objects));
  gone_.reserve(order_.size());
  size_ = used;
}

std::uint32_t ObjectTree::insert(std::uint32_t object) noexcept {
  std::uint32_t slot = size_;
  if (!gone_.empty())
    slot = gone_.back(), gone_.pop_back();
  else if (size_ < order_.size())
    ++size_;
  else
    return kNoObject;
  order_[slot] = object;
  return slot;
}

void ObjectTree::erase(std::uint32_t slot) noexcept {
  order_[slot] = kNoObject;
  gone_.push_back(slot);
  empty_lane(slot);
  refit_above(slot);
}

void ObjectTree::drop_gone() noexcept {
  const auto end = order_.begin() + size_;
  size_ = static_cast<std::uint32_t>(std::remove(order_.begin(), end, kNoObject) - order_.begin());
  gone_.clear();
}

void ObjectTree::empty_lane(std::uint32_t slot) noexcept {
  Node& node = nodes_[slot / kWidth];
  const std::uint32_t lane = slot % kWidth;
  node.highest_object[lane] = -1;
  for (int i = 0; i < 3; ++i) {
    node.low[i][lane] = std::numeric_limits<float>::infinity();
    node.high[i][lane] = -std::numeric_limits<float>::infinity();
  }
}

FloatFrame ObjectTree::sort(std::span<const Sphere> spheres, std::span<std::uint32_t> slot_of) noexcept {
  const std::uint32_t before = size_;
  drop_gone();
  for (std::uint32_t slot = size_; slot < before; ++slot) empty_lane(slot);
  FloatFrame frame;
  sort_range(spheres, 0, size(), &frame);
  // Floats are finest about their origin: put it where objects are, whatever strays.
  if (size() > 0) {
    const Vector3& middle = spheres[order_[size() / 2]].centre;
    if (is_finite(middle)) frame.origin = middle;
  }
  for (std::uint32_t slot = 0; slot < size(); ++slot) slot_of[order_[slot]] = slot;
  return frame;
}

// Morton order within the range's own bounds. Objects that share a cell are sorted again within theirs, so
// that a crowd far smaller than the scene is told apart as well. A level zooms in by 1023: doubles end it.
void ObjectTree::sort_range(std::span<const Sphere> spheres, std::uint32_t first, std::uint32_t last,
                            FloatFrame* frame) noexcept {
  Vector3 low = Vector3::Constant(kInfinity);
  Vector3 high = Vector3::Constant(-kInfinity);
  for (std::uint32_t slot = first; slot < last; ++slot) {
    const Vector3& c = spheres[order_[slot]].centre;
    if (is_finite(c)) low = low.cwiseMin(c), high = high.cwiseMax(c);
  }
  Vector3 cells_per_metre = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double per_metre = 1023.0 / (high(i) - low(i));
    const bool usable = std::isfinite(low(i)) && std::isfinite(per_metre) && per_metre > 0.0;
    if (usable) cells_per_metre(i) = per_metre;
    if (usable && frame != nullptr) frame->scale(i) = per_metre;
  }
  if (!(cells_per_metre.x() > 0.0 || cells_per_metre.y() > 0.0 || cells_per_metre.z() > 0.0)) return;
  for (std::uint32_t slot = first; slot < last; ++slot)
    keys_[slot] = morton_key(spheres[order_[slot]].centre, low, cells_per_metre);
  sort_by_key(first, last);
  for (std::uint32_t run = first, end = first; run < last; run = end) {
    while (end < last && keys_[end] == keys_[run]) ++end;
    if (end - run > 4 * kWidth) sort_range(spheres, run, end, nullptr);
  }
}

void ObjectTree::sort_by_key(std::uint32_t first, std::uint32_t last) noexcept {
  for (int shift = 0; shift < 30; shift += 10) {
    std::array<std::uint32_t, 1024> start{};
    for (std::uint32_t i = first; i < last; ++i) ++start[(keys_[i] >> shift) & 1023];
    std::exclusive_scan(start.begin(), start.end(), start.begin(), first);
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint32_t slot = start[(keys_[i] >> shift) & 1023]++;
      keys_scratch_[slot] = keys_[i], order_scratch_[slot] = order_[i];
    }
    std::copy(keys_scratch_.begin() + first, keys_scratch_.begin() + last, keys_.begin() + first);
    std::copy(order_scratch_.begin() + first, order_scratch_.begin() + last, order_.begin() + first);
  }
}

void ObjectTree::refit_level(std::size_t level) noexcept {
  const std::uint32_t children = level_start_[level] - level_start_[level - 1];
  for (std::uint32_t child = 0; child < children; ++child) refit_lane(level, child);
}

// Takes the box around the level below's node `child`. Returns whether it changed.
bool ObjectTree::refit_lane(std::size_t level, std::uint32_t child) noexcept {
  const Node& below = nodes_[level_start_[level - 1] + child];
  Node& node = nodes_[level_start_[level] + child / kWidth];
  const std::uint32_t lane = child % kWidth;
  bool changed = node.highest_object[lane] != largest_lane(below.highest_object);
  node.highest_object[lane] = largest_lane(below.highest_object);
  for (int i = 0; i < 3; ++i) {
    const float low = -largest_lane(-below.low[i]);
    const float high = largest_lane(below.high[i]);
    changed = changed || low != node.low[i][lane] || high != node.high[i][lane];
    node.low[i][lane] = low, node.high[i][lane] = high;
  }
  return changed;
}

void ObjectTree::refit_one(std::uint32_t slot, const Box& box) noexcept {
  set_lane(slot, box);
  refit_above(slot);
}

void ObjectTree::refit_above(std::uint32_t slot) noexcept {
  std::uint32_t child = slot / kWidth;
  for (std::size_t level = 1; level + 1 < level_start_.size() && refit_lane(level, child); ++level)
    child /= kWidth;
}

}  // namespace touchstone
