#include "touchstone/physics/world/islands/island_solver.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/cone_projection.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {
namespace {

// Forces of bodies that rest but are not still (IslandVelocities) are found anew, though not more often than
// every kPatience steps: where rounding is larger than that, nothing is won.
constexpr std::uint8_t kPatience = 16;
// Of large islands that this made calm: tall stacks topple by a third more from step to step until then.
// Chosen on reported scenes; on stacks and pyramids of other sizes (`other:` in dynamics_scenes_benchmark) 1
// to 16 do alike.
constexpr std::uint8_t kCalmPatience = kPatience / 4;
// A step's work beside linear systems: an entry of W, a row that is set up and tried.
constexpr double kCouplingWork = 10.0, kRowWork = 300.0;
// Of the distance that the contact gap allows: the residual moves nothing by more than this share of it in a
// step.
constexpr double kShareOfGap = 0.1;
// Of the fastest that anything approaches or slides: the residual of large moving islands is not more.
constexpr double kShareOfSpeed = 1e-5;
// Of ContactSolver's tolerance: to this the forces of a large island at rest are found anew.
constexpr double kShareOfExact = 1e-3;
// Of their tolerance, large islands that rest are solved to: from impulses that just hold they creep, their
// points with them, and are solved in each of the steps that follow.
constexpr double kShareOfRest = 0.1;
// Rows of islands that ContactSolver is tried on at once: its linear systems grow with the third power, those
// of ConvexContacts with the number of contacts, four times less at 48 rows.
constexpr std::size_t kDirectRows = 32;
// Islands of bodies alone move where, with the last step's impulses, each of their contacts slides or
// approaches and each body moves there, faster than gravity makes it in kSlowSteps steps, and by more than
// the contact gap in a step. A queue at a stop on a belt that runs on rests, and so does a stack that slides
// as one: something in them does. Then the last digits of their impulses, which hold what rests, are not
// worth their time: nothing is found anew or improved that is within the tolerance, and those of more than
// kDirectRows are held to that of large ones.
// Where work has no end, islands up to this size that ConvexContacts leaves get ContactSolver's first Newton
// steps from there: their linear systems take milliseconds.
constexpr std::size_t kMostPolishedRows = 512;
// An island whose contradiction was proven is taken to contradict itself still for this number of solves, as
// long as the bodies that it presses show it, then tried by all methods again.
constexpr std::uint8_t kSoftSolves = 64;
// Cosine of the angle to a direction that opens: less is along, not out.
constexpr double kAside = 1e-3;
// Newton's, of solve_softly(): the next step goes on with what they leave. Few contacts may take more, by
// their number: until they are solved, a light body between heavy ones is fast.
constexpr int kLeastSoftSteps = 4, kMostSoftSteps = 16, kSoftContacts = 256;
// As many times those of masses beyond kUnlike to 1: their soft answer is harder. Left unfinished it made a
// cube of 1 to 1e6 kg in a row between jaws faster than 0.5 m/s in 4 of 600 scenes, up to 13 m/s; in none
// since.
constexpr int kUnlikeSoftSteps = 2;
// The passive answer, of kMostPassiveSteps Newton steps, is tried where an unsolved island makes something
// faster than both its fastest was and kMostDriven times the commanded speed; and where a solved one with
// commands, or an unsolved one without, makes it kMostPressedOut times as fast: it would be pressed out of a
// wedge that narrow.
// Among masses of up to kUnlike to 1 kMostDriven is 1: of others the passive answer lets heavy ones press on.
// A mechanism's inertia at its contacts is not known here: the mechanism counts as unlike.
constexpr double kMostDriven = 2.0, kMostPressedOut = 10.0, kUnlike = 4.0;
constexpr int kMostPassiveSteps = 12;

int most_soft_steps(const Island& island) {
  return std::clamp(kSoftContacts / std::max(static_cast<int>(island.contacts), 1), kLeastSoftSteps,
                    kMostSoftSteps);
}

/// Parting goes on from what parted in the last step, and moves by less.
int most_parting_steps(const Island& island) {
  return std::min(kLeastSoftSteps, most_soft_steps(island) / 2);
}

/// For kMostPolishedRows.
ContactSolver::Settings with_polish(ContactSolver::Settings settings) {
  settings.most_newton_rows = std::max(settings.most_newton_rows, kMostPolishedRows);
  return settings;
}

/// Adds the work of one solve to another's.
void count(const SolveReport& of, SolveReport& to) {
  to.sweeps += of.sweeps;
  to.newton_steps += of.newton_steps;
}

/// Of a group's velocities while its overlap is parted [m/s]: what moves by the contact gap in a step. But
/// ContactSolver finds no less than its tolerance: less would be sought in every step. And a residual r
/// deepens overlap by r h in a step, of which parting takes the slowest speed times h back: it is a hundredth
/// of that at most, what parting itself leaves.
double parted_tolerance(const StepContext& step) {
  const DynamicsWorld::Settings& settings = step.settings;
  const double slowest = std::min(kLeastPartingSpeed, settings.part_speed);
  return std::max(settings.solver.tolerance,
                  std::min(settings.contact_gap / step.h, kShareOfParting * slowest));
}

}  // namespace

double most_driven(std::span<const std::uint32_t> units, const ContactRows& rows) {
  double lightest = kInfinity, heaviest = 0.0;
  for (const std::uint32_t unit : units) {
    lightest = std::min(lightest, rows.units[unit].mass);
    heaviest = std::max(heaviest, rows.units[unit].mass);
  }
  return lightest > 0.0 && heaviest <= kUnlike * lightest ? 1.0 : kMostDriven;
}

IslandSolver::IslandSolver(const ContactSolver::Settings& settings) : solver_(with_polish(settings)) {}

void IslandSolver::reserve(const ContactRows& rows, std::size_t units, std::size_t blocks,
                           std::size_t widest) {
  const std::size_t most_rows = rows.b.capacity();
  islands_.reserve(units, blocks);
  velocities_.reserve(blocks);
  problem_.reserve(rows, units, widest);
  solver_.reserve(std::min<std::size_t>(most_rows, 1024));
  convex_.reserve(units, most_rows, widest);
  reserve_written(warm_x_, most_rows);
  for (auto* vector : {&patience_, &kept_patience_, &contradicted_, &kept_contradicted_})
    reserve_written(*vector, units);
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
  velocities_.begin(rows);
  for (const Island& island : islands_.all()) solve_island(island, rows, step);
}

void IslandSolver::solve_softly(ContactRows& rows, double tolerance, WorkBudget& budget, StepReport& report) {
  rows.u = rows.b;
  islands_.find(rows);
  velocities_.begin(rows);
  for (const Island& island : islands_.all()) {
    if (velocities_.update(islands_, island, rows).worst <= tolerance) continue;
    problem_.load(islands_, island, rows);
    problem_.load_masses(islands_, island, rows);
    const ConvexReport solved = convex_.solve_softly(problem_.sparse(rows), problem_.x, tolerance, budget,
                                                     most_parting_steps(island));
    report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
    problem_.store_impulses(rows);
    problem_.unload(rows);
  }
}

void IslandSolver::solve_island(const Island& island, ContactRows& rows, StepContext& step) {
  // Most bodies at rest stay at rest: the last step's impulses hold them in this one.
  IslandResidual warm = velocities_.update(islands_, island, rows);
  // A start that is not finite is replaced by zero impulses.
  if (!std::isfinite(warm.worst)) {
    for (const std::size_t block : islands_.blocks_of(island))
      std::fill_n(&rows.x[rows.first_row(block)], block < rows.contacts.size() ? 3 : 1, 0.0);
    warm = velocities_.update(islands_, island, rows);
  }
  if (!std::isfinite(warm.worst)) return fail(island, rows, step);
  // The start holds if its residual is within the tolerance.
  const ContactSolver::Settings& limits = step.settings.solver;
  const bool moves = is_moving(island, rows, step), is_small = island.rows() <= limits.most_path_rows;
  const bool is_exact = is_small && !(moves && island.rows() > kDirectRows);
  const bool holds = warm.worst <= tolerance_of(island, is_exact, rows, step);
  step.budget.spend(kRowWork * static_cast<double>(island.rows()));
  // Large ones for the next hundreds of steps, not to rounding.
  const bool is_calm =
      moves || (is_small || !step.is_bounded() ? warm.is_still : warm.worst <= limits.tolerance);
  // An island that does not hold is solved anew; excess speed and energy are taken out.
  SolveReport solved;
  solved.residual = warm.worst;
  if (!holds || (!is_calm && may_refine(island)))
    solved = solve_anew(island, {warm.worst, is_exact, moves}, rows, step);
  if (!is_small && holds && solved.residual <= limits.tolerance) expect_calm(island);
  if (step.is_bounded() && island.joints == 0) calm(island, rows, step, solved);
  if (step.is_soft && !solved.converged) limit_energy(island, rows, solved);
  // The step's report includes the island.
  StepReport& report = step.report;
  ++report.solves;
  report.unconverged += solved.converged ? 0 : 1;
  report.sweeps += static_cast<std::uint32_t>(solved.sweeps);
  report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
  report.worst_residual = worse_of(report.worst_residual, solved.residual);
}

/// Small islands by ContactSolver, which is exact; where its first steps leave one, or cost more than
/// another start, ConvexContacts, and ContactSolver from there. Larger ones by ConvexContacts.
SolveReport IslandSolver::solve_anew(const Island& island, const Start& start, ContactRows& rows,
                                     StepContext& step) {
  const ContactSolver::Settings& limits = step.settings.solver;
  // The tolerance depends on the size; a start that meets it is refined.
  problem_.load(islands_, island, rows);
  const std::size_t size = island.rows();
  const double tolerance = tolerance_of(island, start.is_exact, rows, step);
  const bool is_refined = start.residual <= tolerance;
  SolveReport solved;
  solved.converged = false;
  warm_x_ = problem_.x;
  // Size and signs of contradiction choose the method.
  const bool is_small = size <= (step.is_bounded() ? limits.most_path_rows : limits.most_newton_rows);
  // Once the work is spent convex problems, which take a step always, go on alone.
  const bool is_direct = (size <= kDirectRows && !step.budget.is_spent()) || is_refined || !step.is_bounded();
  // Of masses that differ what was proven lately stays in doubt: the soft answer of the lighter side is far
  // off.
  const bool may_press = !step.is_parted || presses_on_commands(island, rows);
  const bool is_doubtful =
      !is_refined && may_press && (is_contradicted(island, step) || is_squeezed(island, rows, step));
  if (step.is_soft && !is_doubtful) return solve_soft(island, tolerance, rows, step);
  // Small islands are solved exactly.
  if (is_small && is_direct && !is_doubtful) {
    load_couplings(step.is_bounded() && !is_refined, rows, step);
    solved = solve_dense(rows, step.is_bounded() ? &step.budget : nullptr, !start.moves);
    if (is_refined && solved.converged) refine(island, rows);
    if (solved.converged) velocities_.update(islands_, island, rows);
  }
  // The rest is solved as a convex problem, and polished where it is small.
  if (!solved.converged) {
    problem_.x = warm_x_;
    const SolveReport tried = solved;
    solved = solve_convex(island, is_refined, is_doubtful, rows, step);
    count(tried, solved);
    const bool is_polished = is_small && !start.moves && !is_refined && !step.is_parted;
    if (is_polished && solved.converged && step.is_bounded() && !step.budget.is_spent()) {
      if (!is_direct || is_doubtful) load_couplings(true, rows, step);
      polish(island, rows, step, solved);
    }
    if (!solved.converged && !step.is_bounded() && !is_small && size <= kMostPolishedRows) {
      load_couplings(false, rows, step);
      polish(island, rows, step, solved);
    }
  }
  problem_.unload(rows);
  return solved;
}

/// Of overlapping bodies: the compliant answer (Castro, Permenter, Han 2022) as it is. Heavy ones would fall
/// through light ones that are deep in something, did these not carry them.
SolveReport IslandSolver::solve_soft(const Island& island, double tolerance, ContactRows& rows,
                                     StepContext& step) {
  problem_.load_masses(islands_, island, rows);
  const bool is_unlike = most_driven(islands_.units_of(island), rows) > 1.0;
  const int steps = (is_unlike ? kUnlikeSoftSteps : 1) * most_soft_steps(island);
  const ConvexReport convex =
      convex_.solve_softly(problem_.sparse(rows), problem_.x, tolerance, step.budget, steps, true);
  problem_.store_impulses(rows);
  problem_.unload(rows);
  SolveReport solved;
  solved.newton_steps = convex.newton_steps;
  solved.residual = velocities_.update(islands_, island, rows).worst;
  solved.converged = solved.residual <= tolerance;
  return solved;
}

/// From the convex problems' answer, Newton's method on the laws mostly converges at once.
void IslandSolver::polish(const Island& island, ContactRows& rows, StepContext& step, SolveReport& solved) {
  if (step.budget.is_spent()) return;
  warm_x_ = problem_.x;
  SolveReport polished = solve_dense(rows, step.is_bounded() ? &step.budget : nullptr);
  if (polished.converged) {
    count(solved, polished);
    solved = polished;
    velocities_.update(islands_, island, rows);
  } else {
    count(polished, solved);
    problem_.x = warm_x_;
    problem_.store_impulses(rows);
  }
}

/// Of the contacts' velocities `of` [m/s].
double IslandSolver::most_speed(const Island& island, std::span<const double> of) const {
  double most = 0.0;
  for (const std::size_t block : islands_.blocks_of(island))
    for (std::size_t i = 0; i < 3; ++i) most = worse_of(most, std::abs(of[3 * block + i]));
  return most;
}

/// The most that contacts may leave with [m/s]. Bodies that nothing presses are left alone longer: an
/// unsolved stack of very different masses stands in the next steps, where the passive answer lets it sink.
double IslandSolver::allowed_speed(const Island& island, const ContactRows& rows, bool is_solved,
                                   bool is_soft) const {
  double commanded = 0.0;
  for (const std::size_t block : islands_.blocks_of(island))
    commanded = std::max(commanded, -rows.commanded[block]);
  const double before = most_speed(island, rows.b);
  if (commanded == 0.0) return is_solved || is_soft ? kInfinity : kMostPressedOut * before;
  if (is_solved) return kMostPressedOut * std::max(before, commanded);
  return std::max(before, most_driven(islands_.units_of(island), rows) * commanded);
}

/// Impulses of contacts that contradict each other, or that no solve has found, may shoot out a light body
/// between heavy or commanded ones. Then the passive answer: the compliant one (Castro, Permenter, Han 2022)
/// of the same contacts where commanded movers do not press. Standing still solves these, so that solved it
/// gives no energy: commanded movers go on into the bodies that they meet.
void IslandSolver::calm(const Island& island, ContactRows& rows, StepContext& step, SolveReport& solved) {
  // An allowed speed needs no other answer.
  const double speed = most_speed(island, rows.u);
  if (speed <= allowed_speed(island, rows, solved.converged, step.is_soft)) return;
  // The passive problem starts at 0 and leaves commanded approaches out.
  problem_.load(islands_, island, rows);
  problem_.load_masses(islands_, island, rows);
  warm_x_ = problem_.x;
  std::fill(problem_.x.begin(), problem_.x.end(), 0.0);
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  for (std::size_t i = 0; i < blocks.size(); ++i)
    problem_.b[3 * i] -= std::min(rows.commanded[blocks[i]], 0.0);
  // Its budget is separate and limited by its steps: the solves before may have spent the step's.
  WorkBudget budget;
  const ConvexReport passive = convex_.solve_softly(
      problem_.sparse(rows), problem_.x, tolerance_of(island, false, rows, step), budget, kMostPassiveSteps);
  solved.newton_steps += passive.newton_steps;
  // The passive answer is taken only if it is slower.
  problem_.store_impulses(rows);
  double residual = velocities_.update(islands_, island, rows).worst;
  if (most_speed(island, rows.u) < speed) {
    solved.converged = false;
  } else {
    problem_.x = warm_x_;
    problem_.store_impulses(rows);
    residual = velocities_.update(islands_, island, rows).worst;
  }
  solved.residual = residual;
  problem_.unload(rows);
}

/// Impulses of an unfinished solve may pull, and give energy: they are put into their cones, and the share of
/// them is left that takes most of the velocities' energy, as long as it gives none in all. For they act all
/// along the piece: half of what they make of velocities goes into places, against gravity.
void IslandSolver::limit_energy(const Island& island, ContactRows& rows, SolveReport& solved) {
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  // The impulses are projected on their friction cones.
  for (const std::size_t block : blocks) {
    double* const x = &rows.x[3 * block];
    const double y[3] = {x[0], x[1], x[2]};
    project_on_cone(rows.friction[block], y, length_of(y[1], y[2]), x);
  }
  solved.residual = velocities_.update(islands_, island, rows).worst;
  // The energy is a quadratic function of the impulses' share.
  double by_b = 0.0, by_W = 0.0, lifting = 0.0;
  for (const std::size_t block : blocks)
    for (std::size_t r = 3 * block; r < 3 * block + 3; ++r) {
      by_b += rows.x[r] * rows.b[r];
      by_W += rows.x[r] * (rows.u[r] - rows.b[r]);
    }
  for (const std::uint32_t member : islands_.units_of(island)) {
    const RowUnit& unit = rows.units[member];
    lifting -=
        0.5 * rows.length * (dot(unit.force_W, unit.change_v_W) + dot(unit.push_moment_W, unit.change_w_W));
  }
  // The share that loses most energy is applied.
  if (!(by_W > 0.0)) return;
  const double share = std::max(0.0, std::min(-by_b, -2.0 * (by_b + lifting)) / by_W);
  if (share >= 1.0) return;
  for (const std::size_t block : blocks)
    for (std::size_t r = 3 * block; r < 3 * block + 3; ++r) rows.x[r] *= share;
  solved.residual = velocities_.update(islands_, island, rows).worst;
}

/// @param may_be_parts where ContactSolver's paths, which take W, are not tried
void IslandSolver::load_couplings(bool may_be_parts, ContactRows& rows, StepContext& step) {
  problem_.load_couplings(may_be_parts, rows);
  const auto size = static_cast<double>(problem_.row_count());
  step.budget.spend(kCouplingWork * size * size);
}

SolveReport IslandSolver::solve_dense(ContactRows& rows, WorkBudget* budget, bool is_improved) {
  const SolveReport solved = solver_.solve(problem_.dense(), problem_.x, budget, is_improved);
  problem_.store_impulses(rows);
  return solved;
}

/// Where the step's work ends, the best found so far.
SolveReport IslandSolver::solve_convex(const Island& island, bool is_refined, bool is_doubtful,
                                       ContactRows& rows, StepContext& step) {
  const double tolerance = tolerance_of(island, false, rows, step);
  const double aim = is_refined        ? kShareOfExact * step.settings.solver.tolerance
                     : step.is_resting ? kShareOfRest * tolerance
                                       : tolerance;
  problem_.load_masses(islands_, island, rows);
  // Signs of a contradiction decide when the soft answer is tried.
  using Softness = ConvexContacts::Softness;
  const Softness soft = !is_doubtful                    ? Softness::last
                        : is_contradicted(island, step) ? Softness::first
                                                        : Softness::maybe;
  // Of bodies that commanded ones are in already it is the answer: others press them out.
  const int soft_alone = is_doubtful && step.is_parted ? most_soft_steps(island) : 0;
  const ConvexReport convex =
      convex_.solve(problem_.sparse(rows, step.is_resting), problem_.x, aim, step.budget, soft, soft_alone);
  problem_.store_impulses(rows);
  // The island's velocities decide whether it is solved.
  SolveReport solved;
  solved.newton_steps = convex.newton_steps;
  solved.residual = velocities_.update(islands_, island, rows).worst;
  solved.converged = solved.residual <= tolerance;
  // Units remember a contradiction for some solves.
  step.report.contradictory += convex.is_contradictory ? 1 : 0;
  for (const std::uint32_t unit : islands_.units_of(island)) {
    std::uint8_t& left = contradicted_[unit];
    if (convex.is_certain || (convex.is_contradictory && left == 0))
      left = kSoftSolves;
    else if (!convex.is_contradictory && !convex.is_undecided)
      left = 0;
    else if (left > 0)
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

/// Two steps on end: the first stops the motion, the second finds the forces without those that stopped it.
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

bool IslandSolver::is_contradicted(std::span<const std::uint32_t> units) const {
  return std::any_of(units.begin(), units.end(),
                     [&](std::uint32_t unit) { return contradicted_[unit] != 0; });
}

/// Else standing still is a solution, whatever was proven lately.
bool IslandSolver::presses_on_commands(const Island& island, const ContactRows& rows) const {
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  return std::any_of(blocks.begin(), blocks.end(), [&](std::size_t block) {
    return rows.commanded[block] < 0.0 || (block >= rows.contacts.size() && rows.commanded[block] > 0.0);
  });
}

/// See kSlowSteps. @pre rows.u and the units' changes are those of the last step's impulses
bool IslandSolver::is_moving(const Island& island, const ContactRows& rows, const StepContext& step) const {
  if (!step.is_bounded() || island.joints > 0) return false;
  const DynamicsWorld::Settings& settings = step.settings;
  const double slow = std::max(step.slow_speed(), settings.contact_gap / step.h);
  // What a force or a commanded mover makes of b is no motion: impulses hold it.
  const auto is_fast = [&](const ContactRows::Side& side) {
    if (side.unit == kNoUnit) return true;
    const RowUnit& unit = rows.units[side.unit];
    const Vector3 w_W = unit.w_W + unit.change_w_W;
    return unit.is_body() && norm(unit.v_W + unit.change_v_W + cross(w_W, side.lever_W)) > slow;
  };
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  return std::all_of(blocks.begin(), blocks.end(), [&](std::size_t block) {
    const double* const u = &rows.u[3 * block];
    const ContactRows::Contact& contact = rows.contacts[block];
    return length_of(u[0], length_of(u[1], u[2])) > slow && is_fast(contact.sides[0]) &&
           is_fast(contact.sides[1]);
  });
}

/// Then the soft answer comes first.
bool IslandSolver::is_contradicted(const Island& island, const StepContext& step) const {
  return step.is_bounded() && is_contradicted(islands_.units_of(island));
}

/// Whether something that moves as commanded presses on bodies that have no common direction away from those
/// that do not yield: most contradictory contacts look so, and some others. Without such a mover the velocity
/// 0 is one that all contacts allow.
bool IslandSolver::is_squeezed(const Island& island, const ContactRows& rows, const StepContext& step) const {
  if (!step.is_bounded() || island.joints > 0) return false;
  const std::span<const std::size_t> blocks = islands_.blocks_of(island);
  const auto outward = [&](std::size_t block, Vector3& n_W) {  // of those that do not yield
    const ContactRows::Contact& contact = rows.contacts[block];
    const bool is_a = contact.sides[0].unit == kNoUnit, is_b = contact.sides[1].unit == kNoUnit;
    n_W = is_a ? contact.n_W : -contact.n_W;
    return is_a || is_b;
  };
  // What an impact stopped presses on, whichever way its velocity is rounded.
  const double still = step.settings.solver.tolerance;
  bool is_pressed = false;
  Vector3 n_W, sum_W = Vector3::Zero();
  for (const std::size_t block : blocks) {
    if (!outward(block, n_W)) continue;
    sum_W += n_W;
    is_pressed = is_pressed || (rows.commanded[block] < 0.0 && rows.b[3 * block] <= still);
  }
  if (!is_pressed) return false;
  return std::any_of(blocks.begin(), blocks.end(), [&](std::size_t block) {
    return outward(block, n_W) && !(dot(n_W, sum_W) > kAside * norm(sum_W));
  });
}

/// Of an island's residual [m/s].
double IslandSolver::tolerance_of(const Island& island, bool is_exact, const ContactRows& rows,
                                  const StepContext& step) const {
  const double exact = step.is_parted ? parted_tolerance(step) : step.settings.solver.tolerance;
  if (!step.is_bounded() || is_exact) return exact;
  double speed = 0.0;
  for (const std::size_t block : islands_.blocks_of(island)) {
    const std::size_t first = rows.first_row(block);
    const bool is_contact = block < rows.contacts.size();
    // The room of a stop that is far off is no speed: radians in a millisecond.
    if (!is_contact && rows.joints[block - rows.contacts.size()].is_stop && rows.b[first] > 0.0) continue;
    for (std::size_t i = first; i < first + (is_contact ? 3 : 1); ++i)
      speed = std::max(speed, std::abs(rows.b[i]));
  }
  const double share_of_gap = step.is_parted ? 0.0 : kShareOfGap * step.settings.contact_gap / step.h;
  return std::max({exact, share_of_gap, kShareOfSpeed * speed});
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
