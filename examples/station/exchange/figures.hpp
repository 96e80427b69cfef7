#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace touchstone::station {

/// Times in buckets whose width is 1/16 of their octave, from 1 us to some 70 s: percentiles to 6 %. One
/// thread adds, any may read.
class TimeHistogram {
 public:
  void add(double us) noexcept;
  void clear() noexcept;
  std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  double worst_us() const noexcept { return worst_.load(std::memory_order_relaxed); }
  /// The upper end of the bucket that holds the share; 0 where nothing was added. @param share 0 to 1.
  double quantile_us(double share) const noexcept;
  /// Those that took longer, to a bucket's width.
  std::uint64_t above(double us) const noexcept;

 private:
  static constexpr int kPerOctave = 16, kOctaves = 26;
  static constexpr std::size_t kBuckets = kPerOctave * kOctaves;
  static std::size_t bucket_of(double us) noexcept;
  static double upper_end(std::size_t bucket) noexcept;

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> count_{0};
  std::atomic<double> worst_{0.0};
};

/// Of the loop; it writes, any may read.
struct LoopFigures {
  std::atomic<std::uint64_t> frame{0};
  std::atomic<std::uint64_t> missed{0};       ///< steps that ended after the next one was due
  std::atomic<std::uint64_t> allocations{0};  ///< in steps without a control
  std::atomic<std::uint64_t> not_judged{0}, not_recorded{0}, events_lost{0};
  TimeHistogram step;    ///< input taken to frame handed on
  TimeHistogram answer;  ///< of each new input: received to poses decided
};

/// From a hand to the picture, stage by stage.
struct LatencyFigures {
  TimeHistogram input_to_received, received_to_started, started_to_decided, decided_to_sent, sent_to_drawn;
  TimeHistogram input_to_drawn;  ///< by the browser's clock alone
  TimeHistogram difference;      ///< |sum of the stages - input_to_drawn|
};

/// A hand's picture is late after this: the paper's bound [us].
inline constexpr double kLate = 150e3;

/// Deadlines, and each stage from a hand to its picture, of a whole flight: lines to be printed at its end.
std::string figures_text(const LoopFigures& loop, const LatencyFigures& latency);

}  // namespace touchstone::station
