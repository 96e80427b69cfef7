#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// @file
/// Impulses between bodies as one problem: contacts with friction, and joints whose torque is limited.

namespace touchstone::physics {

/// Unknown impulses x [N s] (joint rows: N m s) and velocities u = W x + b [m/s] (rad/s) after them. Rows:
/// for each contact its normal and two tangents, then one for each joint row. W is symmetric and positive
/// semidefinite (the Delassus matrix J M^-1 J^T), b what the velocities were without impulses.
///
///  * A contact of friction f: u_n >= 0, x_n >= 0, one of them 0; |x_t| <= f x_n; where |x_t| is less, u_t is
///    0, else u_t points against x_t (Coulomb's law with a circular cone).
///  * A joint row: lower <= x <= upper; u = 0 within, u >= 0 at lower, u <= 0 at upper. (A brake or motor:
///    plus and minus its torque times the step, b relative to the commanded rate. An end stop: 0 to
///    infinity.)
struct ContactProblem {
  /// Bounds of a joint row's impulse [N m s] or [N s]; may be infinite.
  struct Bounds {
    double lower, upper;
  };

  std::size_t contacts = 0;
  std::span<const double> friction;  ///< one a contact, >= 0
  std::span<const Bounds> bounds;    ///< one a joint row
  std::span<const double> W;         ///< rows() x rows(); empty where J and Y are given
  std::span<const double> b;
  /// W = J Y^T in its parts, rows() x rates, Y being M^-1 J^T by row: fewer multiplications where rows are
  /// kRowsARate times as many as rates. Without joint rows. 0 rates: W is given.
  static constexpr std::size_t kRowsARate = 3;
  /// Their rows are short: a multiplication takes as much longer than those of W.
  static constexpr double kPriceOfRates = 3.0;
  std::size_t rates = 0;
  std::span<const double> J = {}, Y = {};

  std::size_t rows() const { return 3 * contacts + bounds.size(); }
};

/// The natural map's residual of the laws above, the largest over contacts and joint rows [m/s] (rad/s): with
/// w the block's scale (largest diagonal entry of W), for a contact |min(u_n, w x_n)| and w |x_t - P(x_t -
/// u_t / w)|, P the projection on the disc of radius f x_n; for a joint row w |x - P(x - u / w)|, P on its
/// bounds. 0 exactly at solutions.
/// @param u scratch of rows().
double natural_residual(const ContactProblem& problem, std::span<const double> x, std::span<double> u);

}  // namespace touchstone::physics
