#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

/// Pairs that slides have looked at in a frame, against the world's budget. Only those count that are near,
/// so that neither what is remembered nor who comes first shows.
class SlideMeter {
 public:
  void begin(const SlideBudget& budget) {
    budget_ = budget;
    is_timed_ = budget.seconds < kInfinity;
    seen_ = 0;
    if (is_timed_) start_ = Clock::now();
  }
  /// A sub-step begins: each of its `plans` plans may take an equal share of what is left.
  void begin_step(std::size_t plans) {
    pair_share_ = (budget_.pairs - std::min(seen_, budget_.pairs)) / plans;
    time_share_ = std::max(budget_.seconds - elapsed(), 0.0) / static_cast<double>(plans);
  }
  void begin_plan() { open(seen_ + pair_share_, elapsed() + time_share_); }
  /// Checks of paths begin, which may take all that is left.
  void begin_checks() { open(budget_.pairs, budget_.seconds); }

  /// Counts a pair that turned out to be near.
  void add_pair() { ++seen_; }
  void add_pairs(std::uint64_t count) { seen_ += count; }
  /// Before the next pair.
  bool may_go_on() {
    is_late_ = is_late_ || (is_timed_ && elapsed() >= until_);
    return !is_over();
  }
  /// Whether the plan, or the checks, look at more than they may; the order of pairs does not matter.
  bool is_over() const { return is_late_ || seen_ > limit_; }
  /// Takes back what was counted beyond the limit.
  void clip() { seen_ = std::min(seen_, limit_); }
  bool has_left() const { return seen_ < budget_.pairs && elapsed() < budget_.seconds; }
  std::uint64_t seen() const { return seen_; }
  bool is_limited() const { return is_timed_ || budget_.pairs < std::numeric_limits<std::uint64_t>::max(); }

 private:
  using Clock = std::chrono::steady_clock;

  void open(std::uint64_t limit, double until) { limit_ = limit, until_ = until, is_late_ = false; }
  double elapsed() const {
    return is_timed_ ? std::chrono::duration<double>(Clock::now() - start_).count() : 0.0;
  }

  SlideBudget budget_;
  Clock::time_point start_;
  std::uint64_t seen_ = 0, limit_ = 0, pair_share_ = 0;
  double until_ = 0.0, time_share_ = 0.0;
  bool is_timed_ = false, is_late_ = false;
};

}  // namespace touchstone
