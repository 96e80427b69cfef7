#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

/// @file
/// Sparse symmetric systems of small dense blocks.

namespace touchstone::physics {

/// A = L L^T for a positive definite A whose blocks belong to units (bodies, mechanisms) and pairs of them.
/// Units are eliminated by least degree (Tinney and Walker 1967, scheme 2); what that fills in is known from
/// the pairs alone and is kept as long as they are the same. One order of operations for each number. Owns
/// its memory; no allocation while no system is larger than the largest so far or reserved for.
class BlockCholesky {
 public:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;

  void reserve(std::size_t units, std::size_t pairs, std::size_t widest);
  /// @param sizes rows of each unit. @param pairs of units whose block is not 0: a < b, ascending, each once.
  void analyse(std::span<const std::uint32_t> sizes, std::span<const Pair> pairs);
  /// Multiplications of one factor().
  double work() const { return work_; }

  void clear();
  /// size x size, row by row; the lower triangle counts.
  double* diagonal(std::uint32_t unit) { return &values_[diagonal_[position_[unit]]]; }
  /// Block of a pair that was analysed. @param is_transposed out: whether its rows are b's, not a's.
  double* block(std::uint32_t a, std::uint32_t b, bool& is_transposed);
  /// @return false where a pivot is not positive: A is then spoilt.
  bool factor();
  /// x = A^-1 x. @param first where each unit's rows start in x.
  void solve(std::span<double> x, std::span<const std::size_t> first);

 private:
  void order(std::span<const Pair> pairs);
  void lay_out();
  bool factor_diagonal(std::size_t column);
  void solve_panel(std::size_t column);
  void subtract_from_rest(std::size_t column);
  void solve_forwards(std::span<double> x, std::span<const std::size_t> first) const;
  void solve_backwards(std::span<double> x, std::span<const std::size_t> first) const;
  std::uint64_t* row_of(std::size_t unit) { return &adjacent_[unit * words_]; }

  std::vector<std::uint32_t> sizes_;  // by unit
  std::vector<Pair> pairs_;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> adjacent_, left_;   // bits
  std::vector<std::uint32_t> degree_;            // by unit
  std::vector<std::uint32_t> order_, position_;  // unit by position, position by unit
  std::vector<std::uint32_t> rows_;              // positions of each column's blocks, ascending
  std::vector<std::size_t> first_row_, at_;      // by position; where each block's values start
  std::vector<std::size_t> diagonal_;            // by position
  std::vector<double> values_, transposed_;
  double work_ = 0.0;
};

}  // namespace touchstone::physics
