#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/solver/contact_solver.hpp"
#include "touchstone/physics/solver/convex_contacts.hpp"
#include "touchstone/physics/world/islands/island_problem.hpp"
#include "touchstone/physics/world/islands/island_velocities.hpp"

// Impulses of a group's islands, from its rows alone.

namespace touchstone::physics::stepping {

/// Times what is commanded: the fastest that an unsolved island of these units may make anything. 1 among
/// bodies of alike masses, else more.
double most_driven(std::span<const std::uint32_t> units, const ContactRows& rows);

/// Solves islands one by one: the last step's impulses where they hold, else ContactSolver for small islands
/// and ConvexContacts for larger ones and for those that ContactSolver leaves. Keeps, by unit, what it found
/// out about their islands in earlier steps. Owns its memory.
class IslandSolver {
 public:
  explicit IslandSolver(const ContactSolver::Settings& settings);
  void reserve(const ContactRows& rows, std::size_t units, std::size_t blocks, std::size_t widest);

  /// Finds rows.x and rows.u. Where figures are not finite even without impulses, the step fails.
  void solve(ContactRows& rows, StepContext& step);
  /// For parting: impulses whose velocities miss the rows by no more than the tolerance [m/s], with the
  /// softness of contacts that contradict each other. @param budget of its own.
  void solve_softly(ContactRows& rows, double tolerance, WorkBudget& budget, StepReport& report);

  /// Whether contacts of any of these units were recently proven to contradict each other.
  bool is_contradicted(std::span<const std::uint32_t> units) const;

  /// Saves the state before a step, for this many units; and restores it.
  void keep(std::size_t units);
  void undo();

 private:
  /// The last step's impulses, as an island is found.
  struct Start {
    double residual;       // [m/s]
    bool is_exact, moves;  // it is to be solved to the laws' last digits; is_moving()
  };

  void solve_island(const Island& island, ContactRows& rows, StepContext& step);
  SolveReport solve_anew(const Island& island, const Start& start, ContactRows& rows, StepContext& step);
  void load_couplings(bool may_be_parts, ContactRows& rows, StepContext& step);
  SolveReport solve_dense(ContactRows& rows, WorkBudget* budget, bool is_improved = true);
  SolveReport solve_convex(const Island& island, bool is_refined, bool is_doubtful, ContactRows& rows,
                           StepContext& step);
  SolveReport solve_soft(const Island& island, double tolerance, ContactRows& rows, StepContext& step);
  void polish(const Island& island, ContactRows& rows, StepContext& step, SolveReport& solved);
  double most_speed(const Island& island, std::span<const double> of) const;
  double allowed_speed(const Island& island, const ContactRows& rows, bool is_solved, bool is_soft) const;
  void calm(const Island& island, ContactRows& rows, StepContext& step, SolveReport& solved);
  void limit_energy(const Island& island, ContactRows& rows, SolveReport& solved);
  void refine(const Island& island, ContactRows& rows);
  bool may_refine(const Island& island);
  void expect_calm(const Island& island);
  bool is_contradicted(const Island& island, const StepContext& step) const;
  bool presses_on_commands(const Island& island, const ContactRows& rows) const;
  bool is_moving(const Island& island, const ContactRows& rows, const StepContext& step) const;
  bool is_squeezed(const Island& island, const ContactRows& rows, const StepContext& step) const;
  double tolerance_of(const Island& island, bool is_exact, const ContactRows& rows,
                      const StepContext& step) const;
  void fail(const Island& island, const ContactRows& rows, StepContext& step) const;

  Islands islands_;
  IslandVelocities velocities_;
  IslandProblem problem_;
  ContactSolver solver_;
  ConvexContacts convex_;
  std::vector<double> warm_x_;
  // By unit, and before the step.
  std::vector<std::uint8_t> patience_, kept_patience_;          // steps until its rest may be refined again
  std::vector<std::uint8_t> contradicted_, kept_contradicted_;  // solves for which its island is taken to
                                                                // have contacts that contradict each other
};

}  // namespace touchstone::physics::stepping
