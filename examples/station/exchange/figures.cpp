#include "touchstone/examples/station/exchange/figures.hpp"

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

}  // namespace touchstone::station
