#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "physics/contact_problem.hpp"

// The way to a solution from an easy problem, followed through its turns.

namespace touchstone::physics {

/// Follows the solutions y of the problem softened by s (W + s 1) and smoothed over a width that goes to 0
/// with s, from a large s, where there is one only, towards s = 0.
///
/// Why it arrives: solutions of the softened problem dissipate, so y (W y + b) + s |y|^2 <= 0; with b = J v
/// in the range of W = J M^-1 J^T, s |y|^2 is at most |v|^2 / 4 in the metric of M: as s goes to 0, what
/// softening adds to velocities, s y, falls at least as sqrt(s). The curve of solutions is smooth (Chen and
/// Harker's smoothing), so where it turns back in s (friction makes it do that) steps along its own length go
/// on; steps in s alone would end there. Pseudo-arclength continuation: Allgower and Georg, Numerical
/// Continuation Methods, 1990.
class ContactPath {
 public:
  /// Scaled so that the largest diagonal entry of each block is 1 (or the block is 0). Spans are kept.
  struct Problem {
    std::size_t contacts = 0;
    std::span<const double> friction;
    std::span<const ContactProblem::Bounds> bounds;
    std::span<const double> W, b;
  };

  /// Which of the paths is followed, and how closely.
  struct Way {
    double smoothing;      ///< width over softness, in units of the largest |b|: other widths, other paths
    double most_off;       ///< of the width: how far from the path a point may be
    double shortest_step;  ///< of the length in log softness and in y over its size
    int most_solves;       ///< linear systems
  };

  void reserve(std::size_t rows);
  /// @return false where even the softest problem was not solved.
  bool start(const Problem& problem, const Way& way);
  /// One step along the path. @return false where it got too short to go on.
  bool advance();

  std::span<const double> y() const { return {y_.data(), n_}; }
  double softness() const { return softness_; }
  int linear_solves() const { return linear_solves_; }

 private:
  void set_parameter(double log_softness);
  double evaluate(std::span<const double> point);
  void contact_rows(std::size_t contact, const double* y);
  void joint_row(std::size_t joint, const double* y);
  void tangential_rows(std::size_t row, double friction, const double* y);
  bool correct(double tolerance, int most_steps);
  bool solve_bordered();
  void keep();

  Problem problem_;
  std::size_t n_ = 0;
  int linear_solves_ = 0;
  Way way_ = {};
  double smoothing_ = 0.0;  // width over softness
  double step_ = 0.0, softness_ = 0.0;
  double s_ = 1.0, rho_ = 1.0, width_ = 1.0, size_ = 1.0, least_size_ = 1.0;
  // Points are y, then log s; A_ has a column more than rows to solve for: both right-hand sides.
  std::vector<double> y_, trial_, tangent_, next_tangent_, u_, F_, A_, change_;
};

}  // namespace touchstone::physics
