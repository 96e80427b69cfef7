#pragma once

#include <cstdint>
#include <vector>

#include "physics/contact_path.hpp"
#include "physics/contact_problem.hpp"

namespace touchstone::physics {

/// How a solve went. Not converged: the best found is returned all the same, off by `residual`.
struct SolveReport {
  double residual = 0.0;  ///< natural_residual() of what is returned [m/s]
  int sweeps = 0;         ///< projected Gauss-Seidel
  int newton_steps = 0;   ///< those along paths included
  int rounds = 0;
  bool converged = true;  ///< to the tolerance, or to rounding where that is less than ten times as much
};

/// Solves ContactProblems: projected Gauss-Seidel sweeps, then a semismooth Newton method on the natural map
/// (Alart and Curnier 1991), its linear systems kept regular by a proximal term. With friction the problem is
/// not monotone, and Newton may run into a cycle: further rounds start elsewhere, along a path of softened
/// problems W + s 1, s from 1 to 0, or from other choices of which contacts open, stick and slip, drawn from
/// a generator that every solve starts anew: the same problem gives the same answer. The best of all is
/// returned with its residual. Owns its memory: one a thread; no allocation while no problem is larger than
/// reserved for.
class ContactSolver {
 public:
  /// When a solve is done, and when it gives up.
  struct Settings {
    double tolerance = 1e-10;  ///< of the residual [m/s]
    int sweeps = 4;            ///< before each round's Newton steps
    int newton_steps = 15;     ///< a round
    int rounds = 600;          ///< the iteration cap: one problem in thousands needs more than 10
    std::size_t most_newton_rows =
        192;  ///< larger problems are left to the sweeps, as many as come to the cap
  };

  ContactSolver() = default;
  explicit ContactSolver(const Settings& settings) : settings_(settings) {}
  void reserve(std::size_t rows);
  const Settings& settings() const { return settings_; }

  /// @param x in: where to start from (warm start); out: the best found.
  SolveReport solve(const ContactProblem& problem, std::span<double> x);

 private:
  enum class Status : std::uint8_t { by_value, open, stick, slip };

  void load(const ContactProblem& problem, std::span<const double> x);
  double velocity_of(std::size_t row, const std::vector<double>& y) const;
  void update_velocities(const std::vector<double>& y);
  double residual_of(const std::vector<double>& y);
  void sweep();

  void hold_at(std::size_t row, double value);
  void stop(std::size_t row);
  void slip(std::size_t contact, double z1, double z2, double length);
  void linearise_contact(std::size_t contact);
  void linearise_joint_row(std::size_t joint);
  bool solve_step();
  bool newton_step();
  double newton(bool with_line_search);

  void start_anew(int round);
  bool follow_path(const ContactPath::Way& way);
  bool polish(int steps);
  bool sweep_and_polish(int tries);
  bool is_rounding();
  void draw_statuses(double share_kept);
  void draw_values();
  double draw();
  bool keep_better(double residual);

  Settings settings_;
  ContactPath path_;
  ContactProblem problem_;
  SolveReport report_;
  std::size_t n_ = 0;
  std::uint64_t random_ = 0;
  double rho_ = 1.0;
  // Scaled so that the largest diagonal entry of every block is 1: x = scale y, W' = scale W scale.
  std::vector<double> scale_, W_, b_, y_, u_, best_, trial_, step_, swept_, A_;
  std::vector<ContactProblem::Bounds> bounds_;
  struct Columns {
    std::size_t first, end;
  };
  std::vector<Columns> columns_;              // of W_, by row: all else is 0
  std::vector<std::size_t> end_, block_end_;  // of A_, by row; before elimination, by block
  std::vector<Status> status_;                // by contact, of the next linearisation
};

}  // namespace touchstone::physics
