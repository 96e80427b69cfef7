#include "touchstone/physics/world/islands/island_solver.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics::stepping {
namespace {

// Forces of what rests but is not still (IslandVelocities) are found anew, though not more often than every
// so many steps: where rounding is larger than that, nothing is won.
constexpr std::uint8_t kPatience = 16;
// Of large islands that this made calm: tall stacks topple by a third more from step to step until then.
// Chosen on reported scenes; on stacks and pyramids of other sizes (`other:` in dynamics_scenes_benchmark) 1
// to 16 do alike.
constexpr std::uint8_t kCalmPatience = kPatience / 4;
// A step's work beside linear systems: an entry of W, a row that is set up and tried.
constexpr double kCouplingWork = 10.0, kRowWork = 300.0;
// Of the distance that the contact gap allows: what is left moves nothing by more than this share of it in a
// step.
constexpr double kShareOfGap = 0.1;
// Of the fastest that anything approaches or slides: what is left of large islands that move is not more.
constexpr double kShareOfSpeed = 1e-5;
// Of ContactSolver's tolerance: what the forces of a large island at rest are found anew to.
constexpr double kShareOfExact = 1e-3;
// Rows of islands that ContactSolver is tried on at once: its linear systems grow with the third power, those
// of ConvexContacts with the number of contacts, four times less at 48 rows.
constexpr std::size_t kDirectRows = 32;
// An island whose contradiction was proven is taken to contradict itself still for so many solves, as long as
// what it presses says so, then tried by all means again.
constexpr std::uint8_t kSoftSolves = 64;
// Cosine of the angle to a way out: less is along, not out.
constexpr double kAside = 1e-3;
// Newton's, of solve_softly(): the next step goes on with what they leave.
constexpr int kMostSoftSteps = 4;

/// Adds the work of one solve to another's.
void count(const SolveReport& of, SolveReport& to) {
  to.sweeps += of.sweeps;
  to.newton_steps += of.newton_steps;
}

}  // namespace

void IslandSolver::reserve(const ContactRows& rows, std::size_t units, std::size_t blocks,
                           std::size_t widest) {
  const std::size_t most_rows = rows.b.capacity();
  islands_.reserve(units, blocks);
  velocities_.reserve(blocks);
  problem_.reserve(rows, units, widest);
  solver_.reserve(std::min<std::size_t>(most_rows, 1024));
  convex_.reserve(units, most_rows, widest);
  warm_x_.reserve(most_rows);
  for (auto* vector : {&patience_, &kept_patience_, &contradicted_, &kept_contradicted_})
    vector->reserve(units);
}

void IslandSolver::keep(std::size_t units) {
  kept_patience_.reserve(units);
  kept_patience_ = patience_;
  contradicted_.resize(units, 0);
  kept_contradicted_ = contradicted_;
}

void IslandSolver::undo() {
  patience_ = kept_patience_;
  contradicted_ = kept_contradicted_;
}

void IslandSolver::solve(ContactRows& rows, StepContext& step) {
  rows.u = rows.b;
  // Not all that came to rest together at the same time.
  for (std::size_t i = patience_.size(); i < rows.units.size(); ++i)
    patience_.push_back(static_cast<std::uint8_t>(i % (kPatience - 1)));
  islands_.find(rows);
  for (const Island& island : islands_.all()) solve_island(island, rows, step);
}

void IslandSolver::solve_softly(ContactRows& rows, double tolerance, WorkBudget& budget, StepReport& report) {
  rows.u = rows.b;
  islands_.find(rows);
  for (const Island& island : islands_.all()) {
    if (velocities_.update(islands_, island, rows).worst <= tolerance) continue;
    problem_.load(islands_, island, rows);
    problem_.load_masses(islands_, island, rows);
    const ConvexReport solved =
        convex_.solve_softly(problem_.sparse(rows), problem_.x, tolerance, budget, kMostSoftSteps);
    report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
    problem_.store_impulses(rows);
    problem_.unload(rows);
  }
}

void IslandSolver::solve_island(const Island& island, ContactRows& rows, StepContext& step) {
  // Most of what rests goes on resting: the last step's impulses hold it in this one.
  IslandResidual warm = velocities_.update(islands_, island, rows);
  if (!std::isfinite(warm.worst)) {
    for (const std::size_t block : islands_.blocks_of(island))
      std::fill_n(&rows.x[rows.first_row(block)], block < rows.contacts.size() ? 3 : 1, 0.0);
    warm = velocities_.update(islands_, island, rows);
  }
  if (!std::isfinite(warm.worst)) return fail(island, rows, step);
  const ContactSolver::Settings& limits = step.settings.solver;
  const bool is_small = island.rows() <= limits.most_path_rows;
  const bool holds = warm.worst <= tolerance_of(island, is_small, rows, step);
  step.budget.spend(kRowWork * static_cast<double>(island.rows()));
  // Large ones for the next hundreds of steps, not to rounding.
  const bool is_calm = is_small || !step.is_bounded() ? warm.is_still : warm.worst <= limits.tolerance;
  SolveReport solved;
  solved.residual = warm.worst;
  if (!holds || (!is_calm && may_refine(island))) solved = solve_anew(island, warm.worst, rows, step);
  if (!is_small && holds && solved.residual <= limits.tolerance) expect_calm(island);
  StepReport& report = step.report;
  ++report.solves;
  report.unconverged += solved.converged ? 0 : 1;
  report.sweeps += static_cast<std::uint32_t>(solved.sweeps);
  report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
  report.worst_residual = worse_of(report.worst_residual, solved.residual);
}

/// Small islands by ContactSolver, which is exact; where its first steps leave one, or cost more than
/// another start, ConvexContacts, and ContactSolver from there. Larger ones by ConvexContacts.
SolveReport IslandSolver::solve_anew(const Island& island, double warm_residual, ContactRows& rows,
                                     StepContext& step) {
  const ContactSolver::Settings& limits = step.settings.solver;
  problem_.load(islands_, island, rows);
  const std::size_t size = island.rows();
  const double tolerance = tolerance_of(island, size <= limits.most_path_rows, rows, step);
  const bool is_refined = warm_residual <= tolerance;
  SolveReport solved;
  solved.converged = false;
  warm_x_ = problem_.x;
  const bool is_small = size <= (step.is_bounded() ? limits.most_path_rows : limits.most_newton_rows);
  const bool is_direct = size <= kDirectRows || is_refined || !step.is_bounded();
  const bool is_doubtful = !is_refined && (is_contradicted(island, step) || is_squeezed(island, rows, step));
  if (step.is_soft && !is_doubtful) return solve_soft(island, tolerance, rows, step);
  if (is_small && is_direct && !is_doubtful) {
    load_couplings(rows, step);
    solved = solve_dense(rows, step.is_bounded() ? &step.budget : nullptr);
    if (is_refined && solved.converged) refine(island, rows);
    velocities_.update(islands_, island, rows);
  }
  if (!solved.converged) {
    problem_.x = warm_x_;
    const SolveReport tried = solved;
    solved = solve_convex(island, is_refined, is_doubtful, rows, step);
    count(tried, solved);
    if (is_small && !is_refined && solved.converged && step.is_bounded()) {
      if (!is_direct || is_doubtful) load_couplings(rows, step);
      polish(island, rows, step, solved);
    }
  }
  problem_.unload(rows);
  return solved;
}

/// Of what overlaps: the compliant answer (Castro, Permenter, Han 2022) as it is.
SolveReport IslandSolver::solve_soft(const Island& island, double tolerance, ContactRows& rows,
                                     StepContext& step) {
  problem_.load_masses(islands_, island, rows);
  const ConvexReport convex =
      convex_.solve_softly(problem_.sparse(rows), problem_.x, tolerance, step.budget, kMostSoftSteps);
  problem_.store_impulses(rows);
  problem_.unload(rows);
  SolveReport solved;
  solved.newton_steps = convex.newton_steps;
  solved.residual = velocities_.update(islands_, island, rows).worst;
  solved.converged = solved.residual <= tolerance;
  return solved;
}

/// From what the convex problems leave, Newton's method on the laws mostly converges at once.
void IslandSolver::polish(const Island& island, ContactRows& rows, StepContext& step, SolveReport& solved) {
  if (step.budget.is_spent()) return;
  warm_x_ = problem_.x;
  SolveReport polished = solve_dense(rows, &step.budget);
  if (polished.converged) {
    count(solved, polished);
    solved = polished;
  } else {
    count(polished, solved);
    problem_.x = warm_x_;
    problem_.store_impulses(rows);
  }
  velocities_.update(islands_, island, rows);
}

void IslandSolver::load_couplings(const ContactRows& rows, StepContext& step) {
  problem_.load_couplings(rows);
  const auto size = static_cast<double>(problem_.row_count());
  step.budget.spend(kCouplingWork * size * size);
}

SolveReport IslandSolver::solve_dense(ContactRows& rows, WorkBudget* budget) {
  const SolveReport solved = solver_.solve(problem_.dense(), problem_.x, budget);
  problem_.store_impulses(rows);
  return solved;
}

/// Where the step's work ends, the best found so far.
SolveReport IslandSolver::solve_convex(const Island& island, bool is_refined, bool is_doubtful,
                                       ContactRows& rows, StepContext& step) {
  const double tolerance = tolerance_of(island, false, rows, step);
  const double aim = is_refined ? kShareOfExact * step.settings.solver.tolerance : tolerance;
  problem_.load_masses(islands_, island, rows);
  using Softness = ConvexContacts::Softness;
  const Softness soft = !is_doubtful                    ? Softness::last
                        : is_contradicted(island, step) ? Softness::first
                                                        : Softness::maybe;
  const ConvexReport convex = convex_.solve(problem_.sparse(rows), problem_.x, aim, step.budget, soft);
  problem_.store_impulses(rows);
  SolveReport solved;
  solved.newton_steps = convex.newton_steps;
  solved.residual = velocities_.update(islands_, island, rows).worst;
  solved.converged = solved.residual <= tolerance;
  step.report.contradictory += convex.is_contradictory ? 1 : 0;
  for (const std::uint32_t unit : islands_.units_of(island)) {
    std::uint8_t& left = contradicted_[unit];
    if (!convex.is_contradictory)
      left = 0;
    else if (left == 0 || convex.is_certain)
      left = kSoftSolves;
    else
      --left;
  }
  if (!solved.converged && step.budget.is_spent()) step.report.is_work_spent = true;
  return solved;
}

/// Solves once more, with the difference of W x + b from the velocities that the units will have.
void IslandSolver::refine(const Island& island, ContactRows& rows) {
  velocities_.update(islands_, island, rows);
  // In place: each row's own b is read once, by itself.
  const std::span<const double> W = problem_.dense().W;
  for (std::size_t k = 0; k < problem_.row_count(); ++k)
    problem_.b[k] += rows.u[problem_.group_row(k)] - row_velocity(W, problem_.b, problem_.x, k);
  solve_dense(rows, nullptr);
}

/// Two steps on end: the first stops what moves, the second finds the forces without what stopped it.
bool IslandSolver::may_refine(const Island& island) {
  bool may = true;
  const std::span<const std::uint32_t> units = islands_.units_of(island);
  for (const std::uint32_t unit : units) {
    may = may && (patience_[unit] == 0 || patience_[unit] == kPatience);
    if (patience_[unit] > 0) --patience_[unit];
  }
  if (may)
    for (const std::uint32_t unit : units)
      patience_[unit] = patience_[unit] == kPatience - 1 ? kPatience - 1 : kPatience;
  return may;
}

/// After the second of the two steps of may_refine().
void IslandSolver::expect_calm(const Island& island) {
  for (const std::uint32_t unit : islands_.units_of(island))
    if (patience_[unit] == kPatience - 1) patience_[unit] = kCalmPatience;
}

/// Then the soft answer comes first: contacts were proven to contradict each other lately.
bool IslandSolver::is_contradicted(const Island& island, const StepContext& step) const {
  if (!step.is_bounded()) return false;
  const std::span<const std::uint32_t> units = islands_.units_of(island);
  return std::any_of(units.begin(), units.end(),
                     [&](std::uint32_t unit) { return contradicted_[unit] != 0; });
}

/// Whether something that moves as commanded presses on bodies that have no common way out of what does not
/// give way: most that contradicts itself looks so, and some that does not. Without such a mover the velocity
/// 0 is one that all contacts allow.
bool IslandSolver::is_squeezed(const Island& island, const ContactRows& rows, const StepContext& step) const {
  if (!step.is_bounded() || island.joints > 0) return false;
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  const auto outward = [&](std::size_t block, Vector3& n_W) {  // of what does not give way
    const ContactRows::Contact& contact = rows.contacts[block];
    const bool is_a = contact.sides[0].unit == kNoUnit, is_b = contact.sides[1].unit == kNoUnit;
    n_W = is_a ? contact.n_W : -contact.n_W;
    return is_a || is_b;
  };
  bool is_pressed = false;
  Vector3 n_W, sum_W = Vector3::Zero();
  for (const std::size_t block : blocks) {
    if (!outward(block, n_W)) continue;
    sum_W += n_W;
    is_pressed = is_pressed || (rows.commanded[block] < 0.0 && rows.b[3 * block] < 0.0);
  }
  if (!is_pressed) return false;
  return std::any_of(blocks.begin(), blocks.end(), [&](std::size_t block) {
    return outward(block, n_W) && !(dot(n_W, sum_W) > kAside * norm(sum_W));
  });
}

/// Of an island's residual [m/s].
double IslandSolver::tolerance_of(const Island& island, bool is_exact, const ContactRows& rows,
                                  const StepContext& step) const {
  const double exact = step.settings.solver.tolerance;
  if (!step.is_bounded() || is_exact) return exact;
  double speed = 0.0;
  for (const std::size_t block : islands_.blocks_of(island)) {
    const std::size_t first = rows.first_row(block);
    for (std::size_t i = first; i < first + (block < rows.contacts.size() ? 3 : 1); ++i)
      speed = std::max(speed, std::abs(rows.b[i]));
  }
  return std::max({exact, kShareOfGap * step.settings.contact_gap / step.h, kShareOfSpeed * speed});
}

/// The step ends here; the first that the island would move is named.
void IslandSolver::fail(const Island& island, const ContactRows& rows, StepContext& step) const {
  const std::uint32_t unit = islands_.units_of(island).front();
  if (rows.units[unit].is_body())
    step.fail(StepFailure::body, unit);
  else
    step.fail(StepFailure::mechanism, unit - rows.first_mechanism);
}

}  // namespace touchstone::physics::stepping
