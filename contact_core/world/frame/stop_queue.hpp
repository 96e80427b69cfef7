#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

/// The pairs of one part of a frame, by the time at which they stop a mover, and by mover. A pair whose time
/// changes is put in again, and its older entries are skipped. Allocates only where there are more pairs than
/// were reserved.
class StopQueue {
 public:
  void reserve(std::size_t pairs) {
    reserve_more(times_, 4 * pairs), reserve_more(of_root_, 2 * pairs), reserve_more(due_, 4 * pairs);
  }

  /// Removes all pairs.
  void clear() { times_.clear(), of_root_.clear(); }
  void forget_times() { times_.clear(); }

  /// Adds a pair of a root. All calls come before order_roots().
  void concern(std::uint32_t root, std::uint32_t pair) { of_root_.emplace_back(root, pair); }
  void order_roots() { std::sort(of_root_.begin(), of_root_.end()); }
  /// (root, pair), pairs ascending.
  std::span<const std::pair<std::uint32_t, std::uint32_t>> of(std::uint32_t root) const {
    const auto first = std::lower_bound(of_root_.begin(), of_root_.end(), std::pair{root, 0u});
    auto last = first;
    while (last != of_root_.end() && last->first == root) ++last;
    return {first, last};
  }

  void put(double s, std::uint32_t pair) {
    times_.emplace_back(s, pair);
    std::push_heap(times_.begin(), times_.end(), std::greater<>());
  }

  /// Takes out the pairs of the least time that is(s, pair) says is still theirs: due(), ascending, once
  /// each. @returns their time; infinity: there are none.
  template <class Is>
  double take_first(Is is) {
    due_.clear();
    double least = kInfinity;
    while (!times_.empty() && (due_.empty() || times_.front().first == least)) {
      const auto [s, pair] = times_.front();
      std::pop_heap(times_.begin(), times_.end(), std::greater<>());
      times_.pop_back();
      if (!is(s, pair)) continue;
      least = s;
      due_.push_back(pair);
    }
    std::sort(due_.begin(), due_.end());
    due_.erase(std::unique(due_.begin(), due_.end()), due_.end());
    return least;
  }
  std::span<const std::uint32_t> due() const { return due_; }

 private:
  std::vector<std::pair<double, std::uint32_t>> times_;           // a heap, the least in front
  std::vector<std::pair<std::uint32_t, std::uint32_t>> of_root_;  // sorted
  std::vector<std::uint32_t> due_;
};

}  // namespace touchstone
