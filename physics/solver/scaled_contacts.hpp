#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "touchstone/physics/solver/contact_problem.hpp"

/// @file
/// Contact problems in units of their own: what the solver's methods share.

namespace touchstone::physics {

/// A problem scaled so that the largest diagonal entry of W of each block (a contact, a joint row) is 1, or
/// the block is 0. Spans are kept.
struct ScaledContacts {
  std::size_t contacts = 0;
  std::span<const double> friction;
  std::span<const ContactProblem::Bounds> bounds;
  std::span<const double> W, b;

  std::size_t rows() const { return b.size(); }
  std::size_t blocks() const { return contacts + bounds.size(); }
  std::size_t row(std::size_t block) const { return block < contacts ? 3 * block : 2 * contacts + block; }
};

/// Owns a scaled problem: impulses x = scale y, W' = scale W scale.
class ScaledProblem {
 public:
  /// Columns of a row of W: all else is 0.
  struct Columns {
    std::size_t first, end;
  };

  void reserve(std::size_t rows);
  /// @param y out: x, scaled.
  void load(const ContactProblem& problem, std::span<const double> x, std::span<double> y);

  const ScaledContacts& view() const { return view_; }
  const ContactProblem& unscaled() const { return problem_; }
  /// @pre !is_by_rates()
  Columns columns(std::size_t row) const { return columns_[row]; }
  /// J and Y of a row, scaled, and which rates its contact's rows have. @pre is_by_rates()
  const double* J(std::size_t row) const { return &J_[row * problem_.rates]; }
  const double* Y(std::size_t row) const { return &Y_[row * problem_.rates]; }
  Columns rates(std::size_t contact) const { return rates_[contact]; }
  /// 0: of a block that no impulse moves.
  double scale(std::size_t row) const { return scale_[row]; }

  bool is_by_rates() const { return problem_.rates > 0; }
  /// The natural map's residual in the problem's own units; u out: velocities, scaled.
  double residual(std::span<const double> y, std::span<double> u);
  /// One block after the other, the others held: the normal to its solution, the tangents by one projected
  /// step as long as their own block's largest eigenvalue allows.
  void sweep(std::span<double> y);
  /// Multiplications of a residual, or of a sweep.
  double work() const { return work_; }
  /// Below this a residual at y is rounding, in the problem's own units.
  double rounding(std::span<const double> y) const;

 private:
  void load_rates();
  void load_couplings();
  double velocity(std::size_t row, std::span<const double> y) const;
  double velocity_by_rates(std::size_t row) const;
  void add_to_rates(std::size_t row, double impulse);
  void find_rates(std::span<const double> y);
  void sweep_by_rates(std::span<double> y);

  ContactProblem problem_;
  ScaledContacts view_;
  std::vector<double> scale_, W_, b_;
  std::vector<ContactProblem::Bounds> bounds_;
  std::vector<Columns> columns_;
  std::vector<double> J_, Y_;
  std::vector<Columns> rates_;  // by contact
  std::vector<double> w_;       // scratch, by rate
  double work_ = 0.0;
};

}  // namespace touchstone::physics
