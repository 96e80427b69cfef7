#pragma once

#include <chrono>

#include "touchstone/contact_core/geometry/constants.hpp"

/// @file
/// How much work a step may take.

namespace touchstone::physics {

/// Counts multiplications of linear algebra, so that a step ends at the same place on every machine. With a
/// time limit it ends by the clock, and results depend on the machine.
class WorkBudget {
 public:
  static constexpr double kNoEnd = kInfinity;

  /// @param multiplications left from now on. @param microseconds of this process's steady clock.
  void start(double multiplications, double microseconds = kNoEnd) {
    left_ = multiplications;
    is_timed_ = microseconds < kNoEnd;
    if (is_timed_)
      end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double, std::micro>(microseconds));
  }
  /// So much from now on; the clock goes on.
  void grant(double multiplications) { left_ = multiplications; }
  void spend(double multiplications) { left_ -= multiplications; }
  bool is_spent() const { return !(left_ > 0.0) || (is_timed_ && Clock::now() >= end_); }
  double left() const { return left_; }

 private:
  using Clock = std::chrono::steady_clock;
  double left_ = kNoEnd;
  bool is_timed_ = false;
  Clock::time_point end_ = {};
};

}  // namespace touchstone::physics
