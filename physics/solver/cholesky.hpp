#pragma once

#include <cmath>
#include <cstddef>
#include <span>

// Small dense symmetric systems in the caller's memory, row by row, in one order of operations.

namespace touchstone::physics {

/// A = L L^T in place: L in the lower triangle, with the inverses of its diagonal; the upper one left as it
/// is.
/// @param A n x n. @return false where a pivot is not positive; A is then spoilt.
inline bool factor_cholesky(std::span<double> A, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    double* const row_j = &A[j * n];
    double pivot = row_j[j];
    for (std::size_t k = 0; k < j; ++k) pivot -= row_j[k] * row_j[k];
    if (!(pivot > 0.0)) return false;
    row_j[j] = 1.0 / std::sqrt(pivot);
    for (std::size_t i = j + 1; i < n; ++i) {
      double* const row_i = &A[i * n];
      double sum = row_i[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row_i[k] * row_j[k];
      row_i[j] = sum * row_j[j];
    }
  }
  return true;
}

/// x = A^-1 x with the factor of A.
inline void solve_cholesky(std::span<const double> L, std::span<double> x) {
  const std::size_t n = x.size();
  std::size_t first = 0;  // what comes before stays 0
  while (first < n && x[first] == 0.0) ++first;
  for (std::size_t i = first; i < n; ++i) {
    double sum = x[i];
    for (std::size_t k = first; k < i; ++k) sum -= L[i * n + k] * x[k];
    x[i] = sum * L[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    x[i] *= L[i * n + i];
    for (std::size_t k = 0; k < i; ++k) x[k] -= L[i * n + k] * x[i];
  }
}

}  // namespace touchstone::physics
