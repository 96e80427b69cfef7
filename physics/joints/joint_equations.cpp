#include "touchstone/physics/joints/joint_equations.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::physics {
namespace {

// Added to each row's diagonal entry of J M^-1 J^T, so that redundant rows have a solution; the
// square root of eps, which refinement takes out of all others: each time the error shrinks by this over
// the row's independent share.
constexpr double kRegular = 0x1p-26;
constexpr int kRefinements = 3;

}  // namespace

void JointEquations::reserve(std::size_t rows) {
  first_column_.reserve(rows);
  for (auto* vector : {&W_, &L_}) vector->reserve(rows * rows);
  for (auto* vector : {&scale_, &rest_, &sum_}) vector->reserve(rows);
}

/// Of W's rows: rows meet that move the same.
void JointEquations::find_first_columns(std::span<const JointRow> rows) {
  first_column_.resize(rows.size());
  const auto meet = [](const JointRow& r, const JointRow& s) {
    for (int i = 0; i < r.count; ++i)
      for (int k = 0; k < s.count; ++k)
        if (r.units[i] == s.units[k]) return true;
    return false;
  };
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::size_t first = 0;
    while (first < r && !meet(rows[r], rows[first])) ++first;
    first_column_[r] = first;
  }
}

bool JointEquations::factor(std::span<const JointRow> rows, std::span<const double> J_all,
                            std::span<const double> Y_all) {
  const std::size_t n = rows.size();
  find_first_columns(rows);
  W_.assign(n * n, 0.0);
  scale_.resize(n);
  // W couples rows that act on a common unit.
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t s = first_column_[r]; s <= r; ++s) {
      double sum = 0.0;
      for (int i = 0; i < rows[r].count; ++i)
        for (int k = 0; k < rows[s].count; ++k) {
          if (rows[r].units[i] != rows[s].units[k]) continue;
          const double* const J = &J_all[rows[r].first[i]];
          const double* const Y = &Y_all[rows[s].first[k]];
          for (std::size_t c = 0; c < rows[r].size[i]; ++c) sum += J[c] * Y[c];
        }
      W_[r * n + s] = sum;
    }
  // A row that nothing moves for has no force.
  for (std::size_t r = 0; r < n; ++r) scale_[r] = W_[r * n + r] > 0.0 ? 1.0 / std::sqrt(W_[r * n + r]) : 0.0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t s = first_column_[r]; s < r; ++s) W_[r * n + s] *= scale_[r] * scale_[s];
    W_[r * n + r] = scale_[r] > 0.0 ? 1.0 : 0.0;
  }
  // The Cholesky factor stays within the profile.
  L_ = W_;
  for (std::size_t r = 0; r < n; ++r) {
    double* const row = &L_[r * n];
    row[r] += kRegular;
    for (std::size_t s = first_column_[r]; s <= r; ++s) {
      const double* const other = &L_[s * n];
      double sum = row[s];
      for (std::size_t k = std::max(first_column_[r], first_column_[s]); k < s; ++k) sum -= row[k] * other[k];
      if (s < r) {
        row[s] = sum * other[s];  // the diagonal holds inverses
        continue;
      }
      if (!(sum > 0.0)) return false;
      row[r] = 1.0 / std::sqrt(sum);
    }
  }
  return true;
}

/// x = (W + kRegular)^-1 x.
void JointEquations::solve(std::vector<double>& x) const {
  const std::size_t n = x.size();
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t s = first_column_[r]; s < r; ++s) x[r] -= L_[r * n + s] * x[s];
    x[r] *= L_[r * n + r];
  }
  for (std::size_t r = n; r-- > 0;) {
    x[r] *= L_[r * n + r];
    for (std::size_t s = first_column_[r]; s < r; ++s) x[s] -= L_[r * n + s] * x[r];
  }
}

void JointEquations::find_multipliers(std::span<double> lambda) {
  const std::size_t n = lambda.size();
  for (std::size_t r = 0; r < n; ++r) lambda[r] *= -scale_[r];
  sum_.assign(n, 0.0);
  rest_.assign(lambda.begin(), lambda.end());
  // Each refinement solves for what is left.
  for (int k = 0; k < kRefinements; ++k) {
    solve(rest_);
    for (std::size_t r = 0; r < n; ++r) sum_[r] += rest_[r];
    rest_.assign(lambda.begin(), lambda.end());
    for (std::size_t r = 0; r < n; ++r) {
      for (std::size_t s = first_column_[r]; s < r; ++s) {
        rest_[r] -= W_[r * n + s] * sum_[s];
        rest_[s] -= W_[r * n + s] * sum_[r];
      }
      rest_[r] -= W_[r * n + r] * sum_[r];
    }
  }
  for (std::size_t r = 0; r < n; ++r) lambda[r] = scale_[r] * sum_[r];
}

}  // namespace touchstone::physics
