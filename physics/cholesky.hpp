#pragma once

#include <cmath>
#include <cstddef>
#include <span>

// Small dense symmetric systems in the caller's memory, row by row, in one order of operations.

namespace touchstone::physics {

/// A = L L^T in place: L in the lower triangle, the upper one left as it is.
/// @param A n x n. @return false where a pivot is not positive; A is then spoilt.
inline bool factor_cholesky(std::span<double> A, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    double* const row_j = &A[j * n];
    double pivot = row_j[j];
    for (std::size_t k = 0; k < j; ++k) pivot -= row_j[k] * row_j[k];
    if (!(pivot > 0.0)) return false;
    row_j[j] = std::sqrt(pivot);
    for (std::size_t i = j + 1; i < n; ++i) {
      double* const row_i = &A[i * n];
      double sum = row_i[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row_i[k] * row_j[k];
      row_i[j] = sum / row_j[j];
    }
  }
  return true;
}

/// x = A^-1 x with the factor of A.
inline void solve_cholesky(std::span<const double> L, std::span<double> x) {
  const std::size_t n = x.size();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = x[i];
    for (std::size_t k = 0; k < i; ++k) sum -= L[i * n + k] * x[k];
    x[i] = sum / L[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    double sum = x[i];
    for (std::size_t k = i + 1; k < n; ++k) sum -= L[k * n + i] * x[k];
    x[i] = sum / L[i * n + i];
  }
}

}  // namespace touchstone::physics
