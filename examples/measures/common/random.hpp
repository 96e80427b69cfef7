#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::measures {

/// xoshiro256** (Blackman and Vigna) seeded by splitmix64, and distributions that use nothing but IEEE
/// arithmetic and sqrt: the same numbers on every compiler, unlike <random>'s distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed);
  std::uint64_t next();
  /// [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// 0 to count - 1.
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((next() >> 32) * count >> 32);
  }
  double sign() { return next() >> 63 ? 1.0 : -1.0; }
  /// (1 + u) * 2^k, k from `low` to `high`.
  double binary_scale(int low, int high);
  /// A multiple of 2^-bits in [low, high).
  double dyadic(double low, double high, int bits);

 private:
  std::array<std::uint64_t, 4> state_;
};

/// One stream for each (seed, stream, index), so that any pair can be made again alone.
std::uint64_t mix_seed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

/// Every coordinate in [low, high).
Vector3 uniform_vector(Random& random, double low, double high);
Vector3 random_direction(Random& random);
Matrix3 random_rotation(Random& random);

/// Fisher-Yates.
template <typename Container>
void shuffle(Container& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    using std::swap;
    swap(items[i - 1], items[random.below(static_cast<std::uint32_t>(i))]);
  }
}

}  // namespace touchstone::measures
