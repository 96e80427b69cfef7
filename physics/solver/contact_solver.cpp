#include "touchstone/physics/solver/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

// The natural map y - P(y - rho u) has the same zeros for every rho > 0, but other cycles of Newton's method.
constexpr std::array<double, 7> kRho = {1.0, 1.0, 0.1, 10.0, 0.3, 3.0, 0.01};
// Newton's method is tried off the path from this softness on, and again each time it has fallen this much.
constexpr double kFirstPolish = 1e-2, kPolishAgain = 0.05;
// Sweeps between Newton's tries off them, and how many tries: most of what Newton's method does not solve at
// once, it does from there, for a tenth of what a path costs.
constexpr int kSweepsBetween = 30, kSweptTries = 4, kSweptSteps = 8;
constexpr int kPathSteps = 8;
// Rounds: the one that goes on from sweeps, the first that follows a path, and the period of the next ones.
constexpr int kSwept = 1, kFirstPath = 2, kPathEvery = 4;
// Linear systems of a round along a path.
constexpr int kPathSolves = 700;
// The caps are for problems of up to kFullRows rows; above, they fall with the fifth power, the
// cost of a linear system being the third: a step of a stack that does not come to a solution is not to last
// for seconds. But not fewer rounds than these.
constexpr double kFullRows = 32.0;
constexpr int kLeastRounds = 8;
// Where work is bounded Newton's method is left after this many steps that found nothing better.
constexpr int kMostIdle = 5;
// A softness below this is rounding of 0.
constexpr double kLeastSoftness = 1e-14;
// In units of the tolerance: a larger residual does not count as solved. More is let pass when all is tried.
constexpr double kMostRounding = 5.0, kMostLateRounding = 9.0;
constexpr int kLate = 4;
// Of the tolerance: a solution as good as that is improved no further where nobody asks for it.
constexpr double kGood = 1e-3;

}  // namespace

void ContactSolver::reserve(std::size_t rows) {
  for (auto* vector : {&y_, &u_, &best_, &trial_, &step_, &start_}) reserve_written(*vector, rows);
  scaled_.reserve(rows);
  const std::size_t newton_rows = std::min(rows, settings_.most_newton_rows);
  newton_.reserve(newton_rows);
  path_.reserve(std::min(rows, settings_.most_path_rows));
}

void ContactSolver::load(const ContactProblem& problem, std::span<const double> x) {
  report_ = {};
  random_ = 0x9e3779b97f4a7c15;
  has_path_ = false;
  const auto rows = static_cast<double>(problem.rows());
  work_ = rows * rows;  // scaling
  const double size = kFullRows / rows;
  share_ = std::min(1.0, size * size * size * size * size);
  for (auto* vector : {&y_, &u_, &best_, &trial_, &step_, &start_}) vector->resize(problem.rows());
  scaled_.load(problem, x, y_);
}

void ContactSolver::sweep(int times) {
  for (int i = 0; i < times; ++i) scaled_.sweep(y_);
  report_.sweeps += times;
}

bool ContactSolver::keep_better(double residual) {
  if (residual < report_.residual) report_.residual = residual, best_ = y_;
  return report_.residual <= settings_.tolerance;
}

/// One step from y_, with line search a shorter one where the whole one makes it worse. Returns the residual
/// there.
double ContactSolver::newton(bool with_line_search) {
  ++report_.newton_steps;
  const double before = residual_of(y_);
  const bool is_found = newton_.step(scaled_, y_, u_, rho_, step_);
  work_ += newton_.work() + scaled_.work();
  if (!is_found) return before;
  const int halvings = with_line_search ? 6 : 1;
  double best = kInfinity;
  double factor = 1.0, best_factor = 0.0;
  for (int i = 0; i < halvings; ++i, factor *= 0.5) {
    for (std::size_t k = 0; k < y_.size(); ++k) trial_[k] = y_[k] + factor * step_[k];
    const double residual = residual_of(trial_);
    work_ += scaled_.work();
    if (residual < best) best = residual, best_factor = factor;
    if (residual < before) break;
  }
  for (std::size_t k = 0; k < y_.size(); ++k) y_[k] += best_factor * step_[k];
  return best;
}

/// Newton's steps from y_ as long as they help. @return whether the best found is good enough.
bool ContactSolver::polish(int steps) {
  double last = kInfinity;
  for (int i = 0; i < steps; ++i) {
    const double residual = newton(false);
    if (keep_better(residual)) return true;
    if (i >= 2 && !(residual < 0.5 * last)) return false;
    last = residual;
  }
  return false;
}

/// From where sweeps lead.
bool ContactSolver::sweep_and_polish(int tries) {
  bool done = false;
  for (int i = 0; i < tries && !done; ++i) {
    sweep(kSweepsBetween);
    start_ = y_;
    rho_ = kRho[static_cast<std::size_t>(i)];
    done = polish(kSweptSteps);
    y_ = start_;
  }
  return done;
}

/// A few sweeps, then Newton's steps: shortened where they do not help, or taken whole whether they help or
/// not.
bool ContactSolver::descend(int steps, bool with_line_search, WorkBudget* budget) {
  sweep(settings_.sweeps);
  bool done = keep_better(residual_of(y_));
  work_ += sweeping_work();
  int idle = 0;  // steps since the last that found something better
  for (int i = 0; i < steps && !done && !(budget != nullptr && (budget->is_spent() || idle == kMostIdle));
       ++i) {
    const double best = report_.residual;
    done = keep_better(newton(with_line_search));
    idle = report_.residual < best ? 0 : idle + 1;
    if (budget != nullptr) budget->spend(work_);
    work_ = 0.0;
  }
  return done;
}

/// Along the path of softened problems, and off it to the solution where it is near enough.
bool ContactSolver::follow_path(std::span<const double> anchor) {
  has_path_ = path_.start(scaled_.view(), anchor);
  next_polish_ = kFirstPolish;
  return go_on_with_path();
}

/// As far as a round's share of work goes; the next may go on.
bool ContactSolver::go_on_with_path() {
  rho_ = 1.0;
  const int before = path_.linear_solves(), most = static_cast<int>(share_ * kPathSolves);
  bool done = false;
  while (has_path_ && !done && path_.linear_solves() - before < most) {
    has_path_ = path_.advance();
    const double softness = path_.softness();
    if (!has_path_ || softness > next_polish_) continue;
    next_polish_ = softness * kPolishAgain;
    std::copy(path_.y().begin(), path_.y().end(), y_.begin());
    done = keep_better(residual_of(y_)) || polish(kPathSteps);
    has_path_ = softness > kLeastSoftness;
  }
  report_.newton_steps += path_.linear_solves() - before;
  return done;
}

/// Whether the best is as good as rounding lets it be, though not as good as asked: by the problem's own
/// figures as well as by the scaled ones.
bool ContactSolver::is_rounding() {
  const double most = (report_.rounds < kLate ? kMostRounding : kMostLateRounding) * settings_.tolerance;
  if (!(report_.residual <= most) || !(report_.residual <= scaled_.rounding(best_))) return false;
  for (std::size_t i = 0; i < best_.size(); ++i) trial_[i] = best_[i] * scaled_.scale(i);
  return natural_residual(scaled_.unscaled(), trial_, step_) <= most;
}

/// [0, 1), xorshift64.
double ContactSolver::draw() {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return static_cast<double>(random_ >> 11) * 0x1p-53;
}

void ContactSolver::draw_values() {
  double largest = 0.0;
  for (const double y : best_) largest = std::max(largest, std::abs(y));
  const ScaledContacts& view = scaled_.view();
  for (std::size_t c = 0; c < view.contacts; ++c) {
    const double normal = draw() < 0.3 ? 0.0 : draw() * largest;
    const double radius = view.friction[c] * normal;
    const double t1 = (2.0 * draw() - 1.0) * radius, t2 = (2.0 * draw() - 1.0) * radius;
    y_[3 * c] = normal, y_[3 * c + 1] = t1, y_[3 * c + 2] = t2;
  }
}

/// After the first: each from where the ones before were not.
bool ContactSolver::try_round(int round) {
  rho_ = kRho[static_cast<std::size_t>(round) % kRho.size()];
  y_ = best_;
  if (round == kSwept) return sweep_and_polish(kSweptTries);
  if (round == kFirstPath) return follow_path({});
  const bool is_path = round % kPathEvery == kFirstPath % kPathEvery;
  if (is_path && has_path_) return go_on_with_path();
  draw_values();
  // Of the problems left after the sweeps, half are solved by whole steps, for a tenth of a path's cost.
  if (!is_path) return descend(2 * settings_.newton_steps, false);
  start_ = y_;
  return follow_path(start_);
}

/// Takes one more Newton step from a solution.
void ContactSolver::improve(WorkBudget* budget) {
  // One more step pays: it converges quadratically, and a steady state is then held by the same impulses for
  // a long time. Each solve has it, whatever the work that is left: it is not counted.
  rho_ = 1.0;
  y_ = best_;
  const double before = report_.residual;
  keep_better(newton(false));
  if (report_.residual < before || before <= 0.0) return;
  // Of contacts that touch without a force it may find nothing better, where sweeps do.
  y_ = best_;
  sweep(settings_.sweeps);
  keep_better(residual_of(y_));
  if (budget != nullptr) budget->spend(sweeping_work());
}

SolveReport ContactSolver::solve(const ContactProblem& problem, std::span<double> x, WorkBudget* budget,
                                 bool is_improved) {
  // The start is kept as the best so far, zero impulses where it is not finite.
  load(problem, x);
  best_ = y_;
  report_.residual = residual_of(y_);
  if (!std::isfinite(report_.residual)) {  // the start is not finite, or the problem
    std::fill(y_.begin(), y_.end(), 0.0);
    best_ = y_;
    report_.residual = residual_of(y_);
  }
  // A problem that is not finite has no solution.
  if (!std::isfinite(report_.residual)) {
    std::fill(x.begin(), x.end(), 0.0);
    report_.converged = false;
    return report_;
  }
  // The problem's size decides the methods and the number of rounds.
  bool done = report_.residual <= settings_.tolerance;
  const bool with_newton = y_.size() <= settings_.most_newton_rows;
  const bool only_newton = with_newton && y_.size() > settings_.most_path_rows;
  const int share_of_rounds = std::max(static_cast<int>(share_ * settings_.rounds), kLeastRounds);
  const int rounds =
      std::min(settings_.rounds, only_newton || budget != nullptr || problem.rates > 0 ? 1 : share_of_rounds);
  // Large problems are swept; others are solved by Newton's method and along paths.
  for (int round = 0; round < rounds && !done; ++round) {
    report_.rounds = round + 1;
    if (!with_newton) {
      sweep(settings_.sweeps);
      done = keep_better(residual_of(y_));
    } else if (round == 0) {
      rho_ = kRho[0];
      done = descend(settings_.newton_steps, true, budget);
    } else {
      done = is_rounding() || try_round(round);
    }
  }
  const bool is_good = report_.residual <= kGood * settings_.tolerance;
  if (done && with_newton && (is_improved || !is_good)) improve(budget);
  // The result is scaled back, and its residual is taken unscaled.
  for (std::size_t i = 0; i < y_.size(); ++i) x[i] = best_[i] * scaled_.scale(i);
  if (done && with_newton) {  // the scaled problem's sums round differently
    report_.residual = std::max(report_.residual, natural_residual(scaled_.unscaled(), x, step_));
    done = report_.residual <= kMostLateRounding * settings_.tolerance;
  }
  report_.converged = done;
  return report_;
}

}  // namespace touchstone::physics
