#include "touchstone/contact_core/broadphase/native/object_tree.hpp"

#include <cmath>
#include <numeric>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr Floats kNoLow = {kNone, kNone, kNone, kNone}, kNoHigh = {-kNone, -kNone, -kNone, -kNone};
constexpr ObjectTree::Node kEmptyNode{
    {kNoLow, kNoLow, kNoLow}, {kNoHigh, kNoHigh, kNoHigh}, {-1, -1, -1, -1}};

template <class Lanes>
auto largest_lane(Lanes v) {
  return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
}

}  // namespace

ObjectTree::ObjectTree(std::span<const std::uint32_t> objects) {
  const auto count = static_cast<std::uint32_t>(objects.size());
  reserve(room_for(count));
  begin_anew(room_for(count));
  for (const std::uint32_t object : objects) append(object);
  clear_nodes();
}

void ObjectTree::reserve(std::uint32_t room) {
  if (has_reserved(room)) return;
  order_.clear(), nodes_.clear(), gone_.clear();
  order_.reserve(2 * std::size_t{room});
  gone_.reserve(order_.capacity());
  nodes_.reserve(2 * nodes_for(room));
  level_start_.reserve(kMostLevels + 2);
}

void ObjectTree::begin_anew(std::uint32_t room) noexcept {
  order_.resize(room);
  size_ = 0;
  gone_.clear();
  find_levels();
}

bool ObjectTree::make_nodes(std::size_t most) noexcept {
  nodes_.resize(std::min<std::size_t>(level_start_.back(), nodes_.size() + most));
  return nodes_.size() == level_start_.back();
}

void ObjectTree::find_levels() noexcept {
  level_start_.assign(1, 0);
  auto count = static_cast<std::uint32_t>(order_.size());
  do {
    count = (count + kWidth - 1) / kWidth;
    level_start_.push_back(level_start_.back() + std::max(count, 1u));
  } while (count > 1);
}

void ObjectTree::clear_nodes() noexcept { nodes_.assign(level_start_.back(), kEmptyNode); }

// An eighth more, and some: those that come stand in no order until the next sort(). All keep their slots.
void ObjectTree::make_room() {
  const std::vector<std::uint32_t> objects(order_.begin(), order_.begin() + size_);
  reserve(room_for(size_));
  begin_anew(room_for(size_));
  for (const std::uint32_t object : objects) append(object);
  clear_nodes();
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
  leave_empty(slot);
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

void ObjectTree::leave_empty(std::uint32_t slot) noexcept {
  if (slot < size_) order_[slot] = kNoObject, gone_.push_back(slot);
  empty_lane(slot);
}

FloatFrame ObjectTree::sort(MortonSort& sort, std::span<const Sphere> spheres,
                            std::span<std::uint32_t> slot_of) noexcept {
  const std::uint32_t before = size_;
  drop_gone();
  for (std::uint32_t slot = size_; slot < before; ++slot) empty_lane(slot);
  std::size_t all = MortonSort::kAll;
  sort.begin(size_);
  sort.go_on(spheres, order(), all);
  for (std::uint32_t slot = 0; slot < size(); ++slot) slot_of[order_[slot]] = slot;
  return sort.frame();
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

void ObjectTree::refit_child(std::uint32_t level, std::uint32_t child) noexcept {
  if (child % kWidth == 0) nodes_[level_start_[level] + child / kWidth] = kEmptyNode;
  refit_lane(level, child);
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
