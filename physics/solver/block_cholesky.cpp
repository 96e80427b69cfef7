#include "touchstone/physics/solver/block_cholesky.hpp"
#include "touchstone/physics/solver/reserved.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace touchstone::physics {
namespace {

constexpr std::size_t kBodyRows = 6;  // of most blocks: unrolled

/// B -= P T: B is rows x columns, P rows x n, T n x columns.
void subtract_product(double* B, const double* P, const double* T, std::size_t rows, std::size_t columns,
                      std::size_t n) {
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t k = 0; k < n; ++k) {
      const double factor = P[r * n + k];
      for (std::size_t c = 0; c < columns; ++c) B[r * columns + c] -= factor * T[k * columns + c];
    }
}

void subtract_body_product(double* __restrict B, const double* __restrict P, const double* __restrict T) {
  for (std::size_t r = 0; r < kBodyRows; ++r) {
    double row[kBodyRows];
    for (std::size_t c = 0; c < kBodyRows; ++c) row[c] = B[r * kBodyRows + c];
    for (std::size_t k = 0; k < kBodyRows; ++k)
      for (std::size_t c = 0; c < kBodyRows; ++c) row[c] -= P[r * kBodyRows + k] * T[k * kBodyRows + c];
    for (std::size_t c = 0; c < kBodyRows; ++c) B[r * kBodyRows + c] = row[c];
  }
}

/// y -= B x, and y -= B^T x; 6 x 6.
void subtract_body_times(double* __restrict y, const double* __restrict B, const double* __restrict x) {
  for (std::size_t i = 0; i < kBodyRows; ++i) {
    double sum = y[i];
    for (std::size_t k = 0; k < kBodyRows; ++k) sum -= B[i * kBodyRows + k] * x[k];
    y[i] = sum;
  }
}
void subtract_body_transposed_times(double* __restrict y, const double* __restrict B,
                                    const double* __restrict x) {
  double sums[kBodyRows];
  for (std::size_t k = 0; k < kBodyRows; ++k) sums[k] = y[k];
  for (std::size_t i = 0; i < kBodyRows; ++i)
    for (std::size_t k = 0; k < kBodyRows; ++k) sums[k] -= B[i * kBodyRows + k] * x[i];
  for (std::size_t k = 0; k < kBodyRows; ++k) y[k] = sums[k];
}

/// P = P L^-T, both 6 x 6, the rows of P side by side. Each number as solve_rows() has it.
void solve_body_rows(const double* __restrict L, double* __restrict P) {
  double T[kBodyRows][kBodyRows];
  for (std::size_t c = 0; c < kBodyRows; ++c) {
    for (std::size_t r = 0; r < kBodyRows; ++r) T[c][r] = P[r * kBodyRows + c];
    for (std::size_t k = 0; k < c; ++k)
      for (std::size_t r = 0; r < kBodyRows; ++r) T[c][r] -= T[k][r] * L[c * kBodyRows + k];
    for (std::size_t r = 0; r < kBodyRows; ++r) T[c][r] *= L[c * kBodyRows + c];
  }
  for (std::size_t c = 0; c < kBodyRows; ++c)
    for (std::size_t r = 0; r < kBodyRows; ++r) P[r * kBodyRows + c] = T[c][r];
}

/// Of `rows` rows, if that is known, else n. With the inverses of its diagonal, as factor_cholesky().
template <std::size_t rows>
bool factor_block(double* A, std::size_t width) {
  const std::size_t n = rows != 0 ? rows : width;
  for (std::size_t j = 0; j < n; ++j) {
    double pivot = A[j * n + j];
    for (std::size_t k = 0; k < j; ++k) pivot -= A[j * n + k] * A[j * n + k];
    if (!(pivot > 0.0)) return false;
    A[j * n + j] = 1.0 / std::sqrt(pivot);
    for (std::size_t i = j + 1; i < n; ++i) {
      double sum = A[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= A[i * n + k] * A[j * n + k];
      A[i * n + j] = sum * A[j * n + j];
    }
  }
  return true;
}

/// For each row of a panel: row L^-T.
void solve_rows(const double* L, double* row, const double* end, std::size_t n) {
  for (; row != end; row += n)
    for (std::size_t c = 0; c < n; ++c) {
      double sum = row[c];
      for (std::size_t k = 0; k < c; ++k) sum -= row[k] * L[c * n + k];
      row[c] = sum * L[c * n + c];
    }
}

}  // namespace

void BlockCholesky::reserve(std::size_t units, std::size_t pairs, std::size_t widest) {
  for (auto* vector : {&sizes_, &degree_, &order_, &position_}) reserve_written(*vector, units);
  reserve_written(pairs_, pairs);
  const std::size_t words = (units + 63) / 64;
  reserve_written(adjacent_, units * words);
  reserve_written(left_, words);
  reserve_written(first_row_, units + 1);
  reserve_written(diagonal_, units);
  reserve_written(transposed_, widest * widest);
  // Fill-in is not known before; more than four times the pairs is rare.
  const std::size_t blocks = 4 * pairs;
  reserve_written(rows_, blocks);
  reserve_written(at_, blocks);
  // Manifolds have several rows a pair.
  reserve_written(values_, (units + blocks) * widest * widest, (units + pairs / 6) * widest * widest);
}

/// The unit with the fewest neighbours first; those are then each other's. Ties go to the first.
void BlockCholesky::order(std::span<const Pair> pairs) {
  const std::size_t n = sizes_.size();
  // The adjacency of the units is stored as rows of bits.
  words_ = (n + 63) / 64;
  adjacent_.assign(n * words_, 0);
  left_.assign(words_, 0);
  for (std::size_t i = 0; i < n; ++i) left_[i / 64] |= std::uint64_t{1} << (i % 64);
  for (const auto& [a, b] : pairs) {
    row_of(a)[b / 64] |= std::uint64_t{1} << (b % 64);
    row_of(b)[a / 64] |= std::uint64_t{1} << (a % 64);
  }
  // A unit's degree counts its neighbours that are not eliminated yet.
  degree_.assign(n, 0);
  const auto count = [&](std::size_t unit) {
    std::uint32_t sum = 0;
    for (std::size_t w = 0; w < words_; ++w)
      sum += static_cast<std::uint32_t>(std::popcount(row_of(unit)[w] & left_[w]));
    return sum;
  };
  for (std::size_t i = 0; i < n; ++i) degree_[i] = count(i);
  // The unit of least degree is eliminated next, which joins its neighbours.
  order_.clear();
  position_.assign(n, 0);
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t next = n;
    for (std::size_t i = 0; i < n; ++i)
      if ((left_[i / 64] >> (i % 64) & 1) != 0 && (next == n || degree_[i] < degree_[next])) next = i;
    position_[next] = static_cast<std::uint32_t>(step);
    order_.push_back(static_cast<std::uint32_t>(next));
    left_[next / 64] &= ~(std::uint64_t{1} << (next % 64));
    std::uint64_t* const mine = row_of(next);
    for (std::size_t w = 0; w < words_; ++w) mine[w] &= left_[w];  // those eliminated with it later
    for (std::size_t w = 0; w < words_; ++w)
      for (std::uint64_t bits = mine[w]; bits != 0; bits &= bits - 1) {
        const std::size_t unit = 64 * w + static_cast<std::size_t>(std::countr_zero(bits));
        for (std::size_t v = 0; v < words_; ++v) row_of(unit)[v] |= mine[v];
        row_of(unit)[unit / 64] &= ~(std::uint64_t{1} << (unit % 64));
        degree_[unit] = count(unit);
      }
  }
}

/// Where each column's blocks lie: its own, then those below it.
void BlockCholesky::lay_out() {
  const std::size_t n = sizes_.size();
  rows_.clear();
  at_.clear();
  first_row_.assign(n + 1, 0);
  diagonal_.assign(n, 0);
  std::size_t values = 0, widest = 0;
  work_ = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    // Each column starts with its diagonal block.
    const std::size_t width = sizes_[order_[j]];
    widest = std::max(widest, width);
    diagonal_[j] = values;
    values += width * width;
    // The blocks below it belong to neighbours that are eliminated later.
    const std::uint64_t* const mine = row_of(order_[j]);
    for (std::size_t w = 0; w < words_; ++w)
      for (std::uint64_t bits = mine[w]; bits != 0; bits &= bits - 1)
        rows_.push_back(position_[64 * w + static_cast<std::size_t>(std::countr_zero(bits))]);
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(first_row_[j]), rows_.end());
    first_row_[j + 1] = rows_.size();
    // Those blocks get their offsets, and the column's work is counted.
    double below = 0.0;
    for (std::size_t r = first_row_[j]; r < rows_.size(); ++r) {
      const std::size_t height = sizes_[order_[rows_[r]]];
      at_.push_back(values);
      values += height * width;
      below += static_cast<double>(height);
    }
    const auto w = static_cast<double>(width);
    work_ += w * (w * w / 6.0 + below * (0.5 * w + 0.5 * below));
  }
  values_.resize(values);
  transposed_.resize(widest * widest);
}

void BlockCholesky::analyse(std::span<const std::uint32_t> sizes, std::span<const Pair> pairs) {
  if (std::equal(sizes.begin(), sizes.end(), sizes_.begin(), sizes_.end()) &&
      std::equal(pairs.begin(), pairs.end(), pairs_.begin(), pairs_.end()))
    return;
  sizes_.assign(sizes.begin(), sizes.end());
  pairs_.assign(pairs.begin(), pairs.end());
  order(pairs);
  lay_out();
}

void BlockCholesky::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

double* BlockCholesky::block(std::uint32_t a, std::uint32_t b, bool& is_transposed) {
  std::uint32_t column = position_[a], row = position_[b];
  is_transposed = column < row;
  if (!is_transposed) std::swap(column, row);
  const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first_row_[column]),
             end = rows_.begin() + static_cast<std::ptrdiff_t>(first_row_[column + 1]);
  return &values_[at_[static_cast<std::size_t>(std::lower_bound(begin, end, row) - rows_.begin())]];
}

bool BlockCholesky::factor_diagonal(std::size_t column) {
  const std::size_t n = sizes_[order_[column]];
  double* const A = &values_[diagonal_[column]];
  return n == kBodyRows ? factor_block<kBodyRows>(A, n) : factor_block<0>(A, n);
}

/// The column's blocks lie one after the other: one matrix.
void BlockCholesky::solve_panel(std::size_t column) {
  const std::size_t n = sizes_[order_[column]], at = diagonal_[column];
  const std::size_t end = column + 1 < diagonal_.size() ? diagonal_[column + 1] : values_.size();
  double* const A = &values_[at];
  if (n != kBodyRows) return solve_rows(A, A + n * n, A + (end - at), n);
  double* P = A + n * n;
  double* const last = A + (end - at);
  for (; last - P >= static_cast<std::ptrdiff_t>(n * n); P += n * n) solve_body_rows(A, P);
  solve_rows(A, P, last, n);
}

void BlockCholesky::subtract_from_rest(std::size_t column) {
  const std::size_t n = sizes_[order_[column]], last = first_row_[column + 1];
  for (std::size_t r = first_row_[column]; r < last; ++r) {
    const std::size_t k = rows_[r], width = sizes_[order_[k]];
    const double* const P = &values_[at_[r]];
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t c = 0; c < n; ++c) transposed_[c * width + i] = P[i * n + c];
    const double* const T = transposed_.data();
    const bool is_of_bodies = n == kBodyRows && width == kBodyRows;
    if (is_of_bodies)
      subtract_body_product(&values_[diagonal_[k]], P, T);
    else
      subtract_product(&values_[diagonal_[k]], P, T, width, width, n);
    std::size_t at = first_row_[k];
    for (std::size_t below = r + 1; below < last; ++below) {
      while (rows_[at] != rows_[below]) ++at;
      const std::size_t height = sizes_[order_[rows_[below]]];
      double* const B = &values_[at_[at]];
      if (is_of_bodies && height == kBodyRows)
        subtract_body_product(B, &values_[at_[below]], T);
      else
        subtract_product(B, &values_[at_[below]], T, height, width, n);
    }
  }
}

bool BlockCholesky::factor() {
  for (std::size_t j = 0; j < order_.size(); ++j) {
    if (!factor_diagonal(j)) return false;
    solve_panel(j);
    subtract_from_rest(j);
  }
  return true;
}

void BlockCholesky::solve(std::span<double> x, std::span<const std::size_t> first) {
  solve_forwards(x, first);
  solve_backwards(x, first);
}

void BlockCholesky::solve_forwards(std::span<double> x, std::span<const std::size_t> first) const {
  const std::size_t columns = order_.size();
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t n = sizes_[order_[j]];
    const double* const L = &values_[diagonal_[j]];
    double* const mine = &x[first[order_[j]]];
    for (std::size_t i = 0; i < n; ++i) {
      double sum = mine[i];
      for (std::size_t k = 0; k < i; ++k) sum -= L[i * n + k] * mine[k];
      mine[i] = sum * L[i * n + i];
    }
    for (std::size_t r = first_row_[j]; r < first_row_[j + 1]; ++r) {
      const std::size_t unit = order_[rows_[r]];
      const double* const B = &values_[at_[r]];
      double* const theirs = &x[first[unit]];
      if (n == kBodyRows && sizes_[unit] == kBodyRows) {
        subtract_body_times(theirs, B, mine);
        continue;
      }
      for (std::size_t i = 0; i < sizes_[unit]; ++i)
        for (std::size_t k = 0; k < n; ++k) theirs[i] -= B[i * n + k] * mine[k];
    }
  }
}

void BlockCholesky::solve_backwards(std::span<double> x, std::span<const std::size_t> first) const {
  for (std::size_t j = order_.size(); j-- > 0;) {
    const std::size_t n = sizes_[order_[j]];
    const double* const L = &values_[diagonal_[j]];
    double* const mine = &x[first[order_[j]]];
    for (std::size_t r = first_row_[j]; r < first_row_[j + 1]; ++r) {
      const std::size_t unit = order_[rows_[r]];
      const double* const B = &values_[at_[r]];
      const double* const theirs = &x[first[unit]];
      if (n == kBodyRows && sizes_[unit] == kBodyRows) {
        subtract_body_transposed_times(mine, B, theirs);
        continue;
      }
      for (std::size_t i = 0; i < sizes_[unit]; ++i)
        for (std::size_t k = 0; k < n; ++k) mine[k] -= B[i * n + k] * theirs[i];
    }
    for (std::size_t i = n; i-- > 0;) {
      mine[i] *= L[i * n + i];
      for (std::size_t k = 0; k < i; ++k) mine[k] -= L[i * n + k] * mine[i];
    }
  }
}

}  // namespace touchstone::physics
