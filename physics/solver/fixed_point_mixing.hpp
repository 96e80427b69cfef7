#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

/// @file
/// Fixed points of maps that lead away from them.

namespace touchstone::physics {

/// Anderson's mixing of the last three results of a map F: the affine combination of them whose miss F(x) - x
/// is least, if F is linear (Walker, Ni, Anderson Acceleration for Fixed-Point Iterations, 2011; two
/// differences). It finds fixed points that F leads away from, in two modes at most. Owns its memory; no
/// allocation up to the size that was reserved or seen. Not for several threads at once.
class FixedPointMixing {
 public:
  void reserve(std::size_t size);
  /// Forgets what was mixed.
  void restart() { known_ = 0; }
  /// @param from what F was applied to. @param to in: what it gave; out: what to apply it to next. As long.
  void mix(std::span<const double> from, std::span<double> to);

 private:
  static constexpr std::size_t kDepth = 2;
  using Shares = std::array<double, kDepth>;

  Shares shares_of(std::span<const double> from, std::span<const double> to) const;

  std::array<std::vector<double>, kDepth> misses_, results_;  // the last one first
  std::size_t known_ = 0;
};

}  // namespace touchstone::physics
