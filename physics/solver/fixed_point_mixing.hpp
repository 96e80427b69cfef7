#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "touchstone/physics/solver/reserved.hpp"

/// @file
/// Fixed points of maps that lead away from them.

namespace touchstone::physics {

/// Anderson's mixing of the last three results of a map F: the affine combination of them whose miss F(x) - x
/// is least, if F is linear (Walker, Ni, Anderson Acceleration for Fixed-Point Iterations, 2011; two
/// differences). It finds fixed points that F leads away from, in two modes at most. Owns its memory; no
/// allocation up to the size that was reserved or seen.
class FixedPointMixing {
 public:
  void reserve(std::size_t size) {
    for (auto* vectors : {&misses_, &results_})
      for (std::vector<double>& vector : *vectors) reserve_written(vector, size);
  }
  /// Forgets what was mixed.
  void restart() { known_ = 0; }

  /// @param from what F was applied to. @param to in: what it gave; out: what to apply it to next.
  void mix(std::span<const double> from, std::span<double> to) {
    // The products of the misses' differences, of the last one and the one before.
    std::array<double, kDepth> by_miss = {};
    double products[kDepth][kDepth] = {};
    for (auto* vectors : {&misses_, &results_})
      for (std::vector<double>& vector : *vectors) vector.resize(to.size());
    for (std::size_t k = 0; k < to.size(); ++k) {
      const double miss = to[k] - from[k];
      std::array<double, kDepth> change = {};
      for (std::size_t i = 0; i < known_; ++i) change[i] = miss - misses_[i][k];
      for (std::size_t i = 0; i < kDepth; ++i) {
        by_miss[i] += change[i] * miss;
        for (std::size_t j = 0; j < kDepth; ++j) products[i][j] += change[i] * change[j];
      }
    }
    const std::array<double, kDepth> shares = least_squares(products, by_miss);
    // The shares of the earlier results take their part; the oldest is forgotten.
    for (std::size_t k = 0; k < to.size(); ++k) {
      const double result = to[k], miss = result - from[k];
      for (std::size_t i = 0; i < known_; ++i) to[k] -= shares[i] * (result - results_[i][k]);
      results_[1][k] = results_[0][k], misses_[1][k] = misses_[0][k];
      results_[0][k] = result, misses_[0][k] = miss;
    }
    known_ = known_ < kDepth ? known_ + 1 : kDepth;
  }

 private:
  static constexpr std::size_t kDepth = 2;
  // Of the products: a smaller determinant is that of parallel differences, of which one does.
  static constexpr double kParallel = 1e-8;

  static std::array<double, kDepth> least_squares(const double (&A)[kDepth][kDepth],
                                                  const std::array<double, kDepth>& b) {
    const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    if (det > kParallel * A[0][0] * A[1][1])
      return {(A[1][1] * b[0] - A[0][1] * b[1]) / det, (A[0][0] * b[1] - A[1][0] * b[0]) / det};
    return {A[0][0] > 0.0 ? b[0] / A[0][0] : 0.0, 0.0};
  }

  std::array<std::vector<double>, kDepth> misses_, results_;  // the last one first
  std::size_t known_ = 0;
};

}  // namespace touchstone::physics
