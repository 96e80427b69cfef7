#pragma once

#include <cstddef>

// The inner loops of dense linear algebra, in one order of operations for each number.

namespace touchstone::physics {

/// u . v in four interleaved sums: one chain of additions would wait for each.
inline double sum_of_products(const double* u, const double* v, std::size_t n) {
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  std::size_t k = 0;
  for (; k + 4 <= n; k += 4)
    for (std::size_t i = 0; i < 4; ++i) sums[i] += u[k + i] * v[k + i];
  for (; k < n; ++k) sums[0] += u[k] * v[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// row -= factor other. @pre they do not overlap
inline void subtract_multiple(double* __restrict row, const double* __restrict other, double factor,
                              std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) row[k] -= factor * other[k];
}

/// Four rows at a time, so that `other` is read once for them.
inline void subtract_multiples(double* __restrict r0, double* __restrict r1, double* __restrict r2,
                               double* __restrict r3, const double* __restrict other, const double* factors,
                               std::size_t n) {
  const double f0 = factors[0], f1 = factors[1], f2 = factors[2], f3 = factors[3];
  for (std::size_t k = 0; k < n; ++k) {
    const double value = other[k];
    r0[k] -= f0 * value;
    r1[k] -= f1 * value;
    r2[k] -= f2 * value;
    r3[k] -= f3 * value;
  }
}

/// Of A, rows of `width`: takes row k's multiples from rows k + 1 to last, columns k + 1 to end. Their
/// entries in column k hold the factors.
inline void eliminate(double* A, std::size_t width, std::size_t k, std::size_t last, std::size_t end) {
  const double* const pivot_row = A + k * width + k + 1;
  const std::size_t n = end - k - 1;
  std::size_t i = k + 1;
  for (; i + 4 <= last; i += 4) {
    double* const row = A + i * width + k;
    const double factors[4] = {row[0], row[width], row[2 * width], row[3 * width]};
    if (factors[0] == 0.0 && factors[1] == 0.0 && factors[2] == 0.0 && factors[3] == 0.0) continue;
    subtract_multiples(row + 1, row + width + 1, row + 2 * width + 1, row + 3 * width + 1, pivot_row, factors,
                       n);
  }
  for (; i < last; ++i) {
    double* const row = A + i * width + k;
    if (row[0] != 0.0) subtract_multiple(row + 1, pivot_row, row[0], n);
  }
}

}  // namespace touchstone::physics
