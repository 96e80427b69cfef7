#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace touchstone::physics {

/// A row of joints' equations: its entries on at most two units, which are bodies, then mechanisms.
struct JointRow {
  std::uint32_t units[2];
  std::size_t first[2];  ///< of the unit's entries, in J and Y
  std::size_t size[2];
  int count;          ///< of units
  std::size_t joint;  ///< that the row belongs to
};

/// The equations W lambda = -errors of a JointSystem, W = J M^-1 J^T, solved by a Cholesky factor within the
/// profile of W and refined as JointSystem states. No allocation while there are no more rows than reserved.
class JointEquations {
 public:
  void reserve(std::size_t rows);

  /// Builds W in units of its diagonal, and its regularised factor. @param J, Y entries of the rows, and of
  /// M^-1 J^T. @return false where W has no factor.
  bool factor(std::span<const JointRow> rows, std::span<const double> J, std::span<const double> Y);
  /// @pre factor() returned true. @param lambda in: the rows' errors; out: the multipliers that correct them.
  void find_multipliers(std::span<double> lambda);

 private:
  void find_first_columns(std::span<const JointRow> rows);
  void solve(std::vector<double>& x) const;

  std::vector<double> W_, L_;  // rows x rows, lower, from each row's first column
  std::vector<std::size_t> first_column_;
  std::vector<double> scale_, rest_, sum_;  // by row
};

}  // namespace touchstone::physics
