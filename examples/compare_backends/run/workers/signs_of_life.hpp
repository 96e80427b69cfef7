#pragma once

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "touchstone/contact_core/registry.hpp"

namespace touchstone::comparison {

/// A count in a file that a worker raises wherever it calls an engine and that returns; whoever waits for the
/// worker sees whether the engine hangs. Costs a nanosecond a call.
class SignsOfLife {
 public:
  /// Maps the file, and creates it where it is missing. @throws std::runtime_error where that fails.
  explicit SignsOfLife(const std::filesystem::path& file);
  ~SignsOfLife();
  SignsOfLife(const SignsOfLife&) = delete;
  SignsOfLife& operator=(const SignsOfLife&) = delete;

  /// From any thread. Of two at once one may be lost: it moved all the same. Ends a process that is a copy of
  /// the one that made this: an engine's call forked it and returned in both, and they would double each
  /// time.
  void give() noexcept {
    if (made_in_ != forks_) _exit(0);
    count_->store(count_->load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  std::uint64_t count() const noexcept { return count_->load(std::memory_order_relaxed); }

 private:
  inline static std::uint64_t forks_ = 0;  ///< from the process that first made one of these to this one

  std::atomic<std::uint64_t>* count_;
  std::uint64_t made_in_;
};

/// Whether the count of a process that is polled stands still for longer than a limit; until the first sign
/// kLimitsOfAStart of it are allowed, as engines as processes have them. In all, kLimitsInAll are, and for
/// each sign a thousandth of the limit more: an engine that sleeps in every call would keep a run for days.
class Patience {
 public:
  using Clock = std::chrono::steady_clock;
  /// Of the time between two polls, no more counts: where this process was stopped, so was the other one.
  static constexpr std::chrono::milliseconds kMostAPoll{100};

  Patience(const SignsOfLife& signs, std::chrono::milliseconds limit, Clock::time_point now)
      : signs_(signs), limit_(limit), polled_(now) {}
  static constexpr int kLimitsInAll = 30;
  static constexpr double kLimitsASign = 1e-3;

  /// Polls, at `now`.
  bool is_over(Clock::time_point now);
  /// Whether it is over for what was taken in all.
  bool is_too_long() const { return in_all_ > allowed_in_all(); }
  std::chrono::duration<double> allowed_in_all() const {
    return limit_ * (kLimitsInAll + kLimitsASign * static_cast<double>(last_));
  }
  /// The silence that is allowed now.
  std::chrono::milliseconds limit() const;

 private:
  const SignsOfLife& signs_;
  std::chrono::milliseconds limit_;
  std::uint64_t last_ = 0;
  Clock::time_point polled_;
  Clock::duration waited_{}, in_all_{};
};

/// A backend whose narrowphases give a sign before and after each call; answers are the inner one's.
/// @param signs outlives them.
BackendRegistry::NarrowphaseEntry watched(const BackendRegistry::NarrowphaseEntry& entry, SignsOfLife& signs);

}  // namespace touchstone::comparison
