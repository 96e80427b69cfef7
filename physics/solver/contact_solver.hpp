#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/physics/solver/contact_newton.hpp"
#include "touchstone/physics/solver/contact_path.hpp"
#include "touchstone/physics/solver/scaled_contacts.hpp"
#include "touchstone/physics/solver/work_budget.hpp"

namespace touchstone::physics {

/// How a solve went. Not converged: the best found is returned all the same, off by `residual`.
struct SolveReport {
  double residual = 0.0;  ///< natural_residual() of what is returned [m/s]
  int sweeps = 0;         ///< projected Gauss-Seidel
  int newton_steps = 0;   ///< those along paths included
  int rounds = 0;
  bool converged = true;  ///< to the tolerance, or to rounding where that is less than ten times as much
};

/// Solves ContactProblems to the laws themselves, in stages. Each starts where those before it left a problem
/// unsolved:
///
///  1. Projected Gauss-Seidel sweeps (Moreau; Jourdan, Alart, Jean, A Gauss-Seidel Like Algorithm to Solve
///     Frictional Contact Problems, 1998), then the semismooth Newton method with line search
///     (ContactNewton).
///  2. More sweeps, Newton from there.
///  3. The path of softened problems (ContactPath), then paths anchored at values drawn at random and Newton
///     from such values.
///
/// With friction the problem is not monotone, and Newton may run into a cycle; that is all that 2 and 3 are
/// for. They serve where there is no work budget (DynamicsWorld::Accuracy::exact). The generator starts anew
/// with every solve: the same problem gives the same answer. The best of all is returned with its residual.
/// Owns its memory: one a thread; no allocation while no problem is larger than reserved for.
class ContactSolver {
 public:
  /// When a solve is done, and when it gives up.
  struct Settings {
    double tolerance = 1e-10;  ///< of the residual [m/s]
    int sweeps = 4;            ///< before the first Newton steps
    int newton_steps = 15;     ///< the first ones
    int rounds = 600;  ///< the iteration cap: one problem in thousands needs more than 10. Above 32 rows
                       ///< fewer, by the fifth power
    std::size_t most_path_rows = 64;  ///< larger problems get the first Newton steps only
    std::size_t most_newton_rows =
        192;  ///< larger problems are left to the sweeps, as many as come to the cap
  };

  ContactSolver() = default;
  explicit ContactSolver(const Settings& settings) : settings_(settings) {}
  void reserve(std::size_t rows);
  const Settings& settings() const { return settings_; }

  /// @param x in: where to start from (warm start); out: the best found.
  /// @param budget the first Newton steps alone, for as long as it lasts; nullptr: all there is, of problems
  /// in parts (ContactProblem::rates) the first Newton steps, too.
  /// @param is_improved one more step from a solution, whose impulses then hold a steady state for a long
  /// time; false: where it is not good to a thousandth of the tolerance.
  SolveReport solve(const ContactProblem& problem, std::span<double> x, WorkBudget* budget = nullptr,
                    bool is_improved = true);

 private:
  void load(const ContactProblem& problem, std::span<const double> x);
  bool try_round(int round);
  double residual_of(const std::vector<double>& y) { return scaled_.residual(y, u_); }
  void sweep(int times);
  /// Of the settings' sweeps, and the residual after them.
  double sweeping_work() const { return static_cast<double>(settings_.sweeps + 1) * scaled_.work(); }
  double newton(bool with_line_search);
  bool keep_better(double residual);
  bool polish(int steps);
  void improve(WorkBudget* budget);
  bool sweep_and_polish(int tries);
  bool descend(int steps, bool with_line_search, WorkBudget* budget = nullptr);
  bool follow_path(std::span<const double> anchor);
  bool go_on_with_path();
  bool is_rounding();
  void draw_values();
  double draw();

  Settings settings_;
  ScaledProblem scaled_;
  ContactNewton newton_;
  ContactPath path_;
  SolveReport report_;
  std::uint64_t random_ = 0;
  double rho_ = 1.0;
  bool has_path_ = false;                                    // that leads further
  double work_ = 0.0;                                        // multiplications of this solve
  double share_ = 1.0;                                       // of the caps, by the problem's size
  double next_polish_ = 0.0;                                 // softness
  std::vector<double> y_, u_, best_, trial_, step_, start_;  // scaled
};

}  // namespace touchstone::physics
