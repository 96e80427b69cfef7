#include "touchstone/physics/solver/fixed_point_mixing.hpp"

#include <algorithm>

#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

// Of the products: a smaller determinant is that of parallel differences, of which one does.
constexpr double kParallel = 1e-8;

}  // namespace

void FixedPointMixing::reserve(std::size_t size) {
  for (auto* vectors : {&misses_, &results_})
    for (std::vector<double>& vector : *vectors) reserve_written(vector, size);
}

/// Of the earlier results: least squares of the miss over its changes since.
FixedPointMixing::Shares FixedPointMixing::shares_of(std::span<const double> from,
                                                     std::span<const double> to) const {
  Shares b = {};
  std::array<Shares, kDepth> A = {};
  for (std::size_t k = 0; k < to.size(); ++k) {
    const double miss = to[k] - from[k];
    Shares change = {};
    for (std::size_t i = 0; i < known_; ++i) change[i] = miss - misses_[i][k];
    for (std::size_t i = 0; i < kDepth; ++i) {
      b[i] += change[i] * miss;
      for (std::size_t j = 0; j < kDepth; ++j) A[i][j] += change[i] * change[j];
    }
  }
  const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
  if (det > kParallel * A[0][0] * A[1][1])
    return {(A[1][1] * b[0] - A[0][1] * b[1]) / det, (A[0][0] * b[1] - A[1][0] * b[0]) / det};
  return {A[0][0] > 0.0 ? b[0] / A[0][0] : 0.0, 0.0};
}

void FixedPointMixing::mix(std::span<const double> from, std::span<double> to) {
  for (auto* vectors : {&misses_, &results_})
    for (std::vector<double>& vector : *vectors) vector.resize(to.size());
  const Shares shares = shares_of(from, to);
  // The earlier results take their shares; the oldest is forgotten.
  for (std::size_t k = 0; k < to.size(); ++k) {
    const double result = to[k], miss = result - from[k];
    for (std::size_t i = 0; i < known_; ++i) to[k] -= shares[i] * (result - results_[i][k]);
    results_[1][k] = results_[0][k], misses_[1][k] = misses_[0][k];
    results_[0][k] = result, misses_[0][k] = miss;
  }
  known_ = std::min(known_ + 1, kDepth);
}

}  // namespace touchstone::physics
