#include "touchstone/examples/station/exchange/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace touchstone::station {

std::size_t TimeHistogram::bucket_of(double us) noexcept {
  if (!(us > 1.0)) return 0;
  if (!(us < std::ldexp(1.0, kOctaves))) return kBuckets - 1;  // infinity has no octave
  int octave = 0;
  const double mantissa = std::frexp(us, &octave);  // [0.5, 1)
  const auto within = static_cast<int>((mantissa - 0.5) * 2.0 * kPerOctave);
  return std::min(kBuckets - 1, static_cast<std::size_t>((octave - 1) * kPerOctave + within));
}

double TimeHistogram::upper_end(std::size_t bucket) noexcept {
  const int octave = static_cast<int>(bucket) / kPerOctave, within = static_cast<int>(bucket) % kPerOctave;
  return std::ldexp(1.0 + (within + 1.0) / kPerOctave, octave);
}

void TimeHistogram::add(double us) noexcept {
  buckets_[bucket_of(us)].fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  if (us > worst_us()) worst_.store(us, std::memory_order_relaxed);
}

void TimeHistogram::clear() noexcept {
  for (auto& bucket : buckets_) bucket.store(0, std::memory_order_relaxed);
  count_.store(0, std::memory_order_relaxed);
  worst_.store(0.0, std::memory_order_relaxed);
}

double TimeHistogram::quantile_us(double share) const noexcept {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count())));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    seen += buckets_[i].load(std::memory_order_relaxed);
    if (seen >= wanted && seen > 0) return std::min(upper_end(i), worst_us());
  }
  return worst_us();
}

std::uint64_t TimeHistogram::above(double us) const noexcept {
  std::uint64_t out = 0;
  for (std::size_t i = bucket_of(us) + 1; i < kBuckets; ++i)
    out += buckets_[i].load(std::memory_order_relaxed);
  return out;
}

namespace {

std::string stage_line(const char* name, const TimeHistogram& stage) {
  return fmt::format("  {:24} median {:7.1f} ms, 99.9 % {:7.1f} ms, worst {:7.1f} ms\n", name,
                     1e-3 * stage.quantile_us(0.5), 1e-3 * stage.quantile_us(0.999), 1e-3 * stage.worst_us());
}

}  // namespace

std::string figures_text(const LoopFigures& loop, const LatencyFigures& latency) {
  std::string out = fmt::format(
      "deadlines missed {} of {}; a step: median {:.0f} us, 99.9 % {:.0f} us, worst {:.0f} us; not judged "
      "{}\n",
      loop.missed.load(), loop.step.count(), loop.step.quantile_us(0.5), loop.step.quantile_us(0.999),
      loop.step.worst_us(), loop.not_judged.load());
  if (loop.answer.count() > 0) {
    out += fmt::format("hands that were obeyed: {}, above 150 ms {}\n", loop.answer.count(),
                       loop.answer.above(kLate));
    out += stage_line("received to decided", loop.answer);
  }
  if (latency.input_to_drawn.count() == 0) return out + "no page drew what it flew\n";
  out += fmt::format("hands that were drawn: {}, above 150 ms {}\n", latency.input_to_drawn.count(),
                     latency.input_to_drawn.above(kLate));
  out += stage_line("input to received", latency.input_to_received);
  out += stage_line("received to step", latency.received_to_started);
  out += stage_line("step to decided", latency.started_to_decided);
  out += stage_line("decided to sent", latency.decided_to_sent);
  out += stage_line("sent to drawn", latency.sent_to_drawn);
  out += stage_line("input to drawn", latency.input_to_drawn);
  return out + stage_line("|sum - input to drawn|", latency.difference);
}

}  // namespace touchstone::station
