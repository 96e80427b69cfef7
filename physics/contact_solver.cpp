#include "physics/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "physics/contact_laws.hpp"

namespace touchstone::physics {
namespace {

// Held rows say u = 0, which redundant contacts say several times over: the proximal term makes them
// independent and, vanishing with the step, moves no solution. 2^-40 of the diagonal is far above rounding
// and far below 1.
constexpr double kProximal = 0x1p-40;
// The natural map y - P(y - rho u) has the same zeros for every rho > 0, but other cycles of Newton's method.
constexpr std::array<double, 7> kRho = {1.0, 1.0, 0.1, 10.0, 0.3, 3.0, 0.01};
// Newton's method is tried off the path from this softness on, and again each time it has fallen this much.
constexpr double kFirstPolish = 1e-2, kPolishAgain = 0.05;
// A path that got here has gone back the way it came.
constexpr double kLostSoftness = 1e3;
// Sweeps between Newton's tries off them, and how many tries: most of what Newton's method does not solve at
// once, it does from there, for a tenth of what a path costs.
constexpr int kSweepsBetween = 30, kSweptTries = 4, kSweptSteps = 8;
// Paths tried: a coarse one, which three in four of what is left end with; then finer ones.
constexpr std::array<ContactPath::Way, 7> kWays = {{{1.0, 0.2, 1e-4, 300},
                                                    {1.0, 0.05, 1e-6, 1500},
                                                    {10.0, 0.2, 1e-4, 300},
                                                    {0.1, 0.2, 1e-4, 300},
                                                    {0.1, 0.02, 1e-7, 2000},
                                                    {10.0, 0.02, 1e-7, 2000},
                                                    {0.01, 0.02, 1e-7, 2000}}};
constexpr int kDrawnTries = 10;
// A residual below this share of what the sums of W y + b are made of is rounding: more than the square root
// of the number of rows times the unit roundoff, so that no problem is given up that could be solved better.
constexpr double kRounding = 0x1p-49;
// In units of the tolerance: what is more does not count as solved. More is let pass when all paths are
// tried.
constexpr double kMostRounding = 5.0, kMostLateRounding = 9.0;
constexpr int kLate = 30;

/// What a round tries, cheap things first.
enum class Round : std::uint8_t { sweeps, path, drawn_sweeps, drawn_newton };
struct Plan {
  Round round;
  const ContactPath::Way* way = nullptr;
};

/// Of the rounds after the first.
Plan plan_of(int round) {
  constexpr int kSecondPath = 3 + kDrawnTries, kDrawn = kSecondPath + 3, kFine = kDrawn + 8, kCoarse = 4;
  if (round == 1) return {Round::sweeps};
  if (round == 2) return {Round::path, &kWays[0]};
  if (round < kSecondPath) return {Round::drawn_sweeps};
  if (round < kDrawn) return {Round::path, &kWays[static_cast<std::size_t>(1 + round - kSecondPath)]};
  const auto way = static_cast<std::size_t>(kCoarse + round - kFine);
  if (round < kFine || way >= kWays.size()) return {Round::drawn_newton};
  return {Round::path, &kWays[way]};
}

}  // namespace

void ContactSolver::reserve(std::size_t rows) {
  for (auto* vector : {&scale_, &b_, &y_, &u_, &best_, &trial_, &step_, &swept_}) vector->reserve(rows);
  W_.reserve(rows * rows);
  const std::size_t newton_rows = std::min(rows, settings_.most_newton_rows);
  A_.reserve(newton_rows * newton_rows);
  bounds_.reserve(rows);
  columns_.reserve(rows);
  end_.reserve(newton_rows);
  block_end_.reserve(newton_rows);
  path_.reserve(newton_rows);
  status_.reserve(rows);
}

void ContactSolver::load(const ContactProblem& problem, std::span<const double> x) {
  problem_ = problem;
  report_ = {};
  random_ = 0x9e3779b97f4a7c15;
  n_ = problem.rows();
  for (auto* vector : {&scale_, &b_, &y_, &u_, &best_, &trial_, &step_, &swept_}) vector->resize(n_);
  W_.resize(n_ * n_);
  columns_.resize(n_);
  status_.assign(problem.contacts, Status::by_value);
  bounds_.assign(problem.bounds.begin(), problem.bounds.end());
  const auto scale_block = [&](std::size_t row, std::size_t size) {
    const double w = block_scale(problem.W, n_, row, size);
    for (std::size_t i = row; i < row + size; ++i) scale_[i] = w > 0.0 ? 1.0 / std::sqrt(w) : 0.0;
  };
  for (std::size_t c = 0; c < problem.contacts; ++c) scale_block(3 * c, 3);
  for (std::size_t i = 3 * problem.contacts; i < n_; ++i) {
    scale_block(i, 1);
    auto& bounds = bounds_[i - 3 * problem.contacts];
    if (scale_[i] > 0.0) bounds = {bounds.lower / scale_[i], bounds.upper / scale_[i]};
  }
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t k = 0; k < n_; ++k) W_[i * n_ + k] = scale_[i] * problem.W[i * n_ + k] * scale_[k];
    Columns& columns = columns_[i];
    columns = {i, i + 1};
    for (std::size_t k = 0; k < i; ++k)
      if (W_[i * n_ + k] != 0.0) {
        columns.first = k;
        break;
      }
    for (std::size_t k = n_; k > i + 1; --k)
      if (W_[i * n_ + k - 1] != 0.0) {
        columns.end = k;
        break;
      }
    b_[i] = scale_[i] * problem.b[i];
    y_[i] = scale_[i] > 0.0 ? x[i] / scale_[i] : 0.0;
  }
}

double ContactSolver::velocity_of(std::size_t row, const std::vector<double>& y) const {
  const auto [first, end] = columns_[row];
  return b_[row] + sum_of_products(&W_[row * n_ + first], &y[first], end - first);
}

void ContactSolver::update_velocities(const std::vector<double>& y) {
  for (std::size_t i = 0; i < n_; ++i) u_[i] = velocity_of(i, y);
}

/// In unscaled velocities; leaves the scaled ones in u_.
double ContactSolver::residual_of(const std::vector<double>& y) {
  update_velocities(y);
  double worst = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (scale_[3 * c] > 0.0)
      worst =
          std::max(worst, contact_residual(1.0, problem_.friction[c], &y[3 * c], &u_[3 * c]) / scale_[3 * c]);
  for (std::size_t i = 3 * problem_.contacts; i < n_; ++i)
    if (scale_[i] > 0.0)
      worst = std::max(
          worst, std::abs(y[i] - clamped(y[i] - u_[i], bounds_[i - 3 * problem_.contacts])) / scale_[i]);
  return worst;
}

/// One block after the other, the others held: the normal to its solution, the tangents by one projected step
/// as long as their own block's largest eigenvalue allows.
void ContactSolver::sweep() {
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const std::size_t i = 3 * c;
    if (scale_[i] == 0.0) continue;
    const double normal = W_[i * n_ + i];
    if (normal > 0.0) y_[i] = std::max(0.0, y_[i] - velocity_of(i, y_) / normal);
    const double u1 = velocity_of(i + 1, y_), u2 = velocity_of(i + 2, y_);
    const double a = W_[(i + 1) * n_ + i + 1], d = W_[(i + 2) * n_ + i + 2], off = W_[(i + 1) * n_ + i + 2];
    const double largest = 0.5 * (a + d) + std::sqrt(0.25 * (a - d) * (a - d) + off * off);
    if (largest > 0.0) {
      y_[i + 1] -= u1 / largest;
      y_[i + 2] -= u2 / largest;
    }
    project_on_disc(problem_.friction[c] * y_[i], y_[i + 1], y_[i + 2]);
  }
  for (std::size_t i = 3 * problem_.contacts; i < n_; ++i)
    if (scale_[i] > 0.0) y_[i] = clamped(y_[i] - velocity_of(i, y_), bounds_[i - 3 * problem_.contacts]);
}

/// y = value.
void ContactSolver::hold_at(std::size_t row, double value) {
  A_[row * n_ + row] = 1.0;
  step_[row] = value - y_[row];
}

/// u = 0.
void ContactSolver::stop(std::size_t row) {
  for (std::size_t k = columns_[row].first; k < columns_[row].end; ++k) A_[row * n_ + k] = W_[row * n_ + k];
  A_[row * n_ + row] += kProximal;
  step_[row] = -u_[row];
}

/// y_t = f y_n z / |z|: its derivative turns with z across z, and grows with y_n along it.
void ContactSolver::slip(std::size_t contact, double z1, double z2, double length) {
  const std::size_t i = 3 * contact;
  const double friction = problem_.friction[contact];
  const double radius = friction * std::max(y_[i], 0.0);
  const double e[2] = {z1 / length, z2 / length};
  const double ratio = std::min(radius / length, 1.0);
  for (std::size_t r = 0; r < 2; ++r) {
    double* const row = &A_[(i + 1 + r) * n_];
    for (std::size_t s = 0; s < 2; ++s) {
      const double across = ratio * ((r == s ? 1.0 : 0.0) - e[r] * e[s]);
      const Columns columns = columns_[i + 1 + s];
      subtract_multiple(row + columns.first, &W_[(i + 1 + s) * n_ + columns.first], -(rho_ * across),
                        columns.end - columns.first);
      row[i + 1 + s] += ((r == s ? 1.0 : 0.0) - across);
    }
    if (y_[i] > 0.0) row[i] -= friction * e[r];
    step_[i + 1 + r] = radius * e[r] - y_[i + 1 + r];
  }
}

void ContactSolver::linearise_contact(std::size_t contact) {
  const std::size_t i = 3 * contact;
  const Status status = status_[contact];
  if (scale_[i] == 0.0 || status == Status::open ||
      (status == Status::by_value && y_[i] - rho_ * u_[i] <= 0.0)) {
    for (std::size_t k = 0; k < 3; ++k) hold_at(i + k, 0.0);
    return;
  }
  stop(i);
  const double z1 = y_[i + 1] - rho_ * u_[i + 1], z2 = y_[i + 2] - rho_ * u_[i + 2];
  const double length = std::sqrt(z1 * z1 + z2 * z2);
  const bool sticks = status == Status::by_value ? length <= problem_.friction[contact] * std::max(y_[i], 0.0)
                                                 : status == Status::stick;
  if (sticks || length == 0.0) {
    stop(i + 1);
    stop(i + 2);
  } else {
    slip(contact, z1, z2, length);
  }
}

void ContactSolver::linearise_joint_row(std::size_t joint) {
  const std::size_t i = 3 * problem_.contacts + joint;
  const auto& bounds = bounds_[joint];
  const double z = y_[i] - rho_ * u_[i];
  if (scale_[i] == 0.0) return hold_at(i, 0.0);
  if (z <= bounds.lower) return hold_at(i, bounds.lower);
  if (z >= bounds.upper) return hold_at(i, bounds.upper);
  stop(i);
}

/// step_ = A_^-1 step_ by elimination with row pivots, each row as far as it may hold anything; A_ is spoilt.
bool ContactSolver::solve_step() {
  const std::size_t n = n_;
  end_.resize(n);
  block_end_.resize(n);
  std::size_t reach = 0;  // rows up to here may hold something in the columns so far: W is symmetric
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t block = i < 3 * problem_.contacts ? i - i % 3 : i;
    const std::size_t last = i < 3 * problem_.contacts ? block + 3 : i + 1;
    end_[i] = last;
    for (std::size_t k = block; k < last; ++k) end_[i] = std::max(end_[i], columns_[k].end);
    // Rows of a contact take each other's columns, so whole contacts are reached.
    block_end_[i] = end_[i];
    if (end_[i] < 3 * problem_.contacts) block_end_[i] += (3 - end_[i] % 3) % 3;
  }
  for (std::size_t k = 0; k < n; ++k) {
    reach = std::max(reach, block_end_[k]);
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < reach; ++i)
      if (std::abs(A_[i * n + k]) > std::abs(A_[pivot * n + k])) pivot = i;
    if (!(std::abs(A_[pivot * n + k]) > 0.0)) return false;
    if (pivot != k) {
      const std::size_t most = std::max(end_[k], end_[pivot]);
      std::swap_ranges(&A_[k * n + k], &A_[k * n] + most, &A_[pivot * n + k]);
      std::swap(end_[k], end_[pivot]);
      std::swap(step_[k], step_[pivot]);
    }
    const double* const row_k = &A_[k * n];
    for (std::size_t i = k + 1; i < reach; ++i) {
      double& entry = A_[i * n + k];
      if (entry == 0.0) continue;
      entry /= row_k[k];
      end_[i] = std::max(end_[i], end_[k]);
      step_[i] -= entry * step_[k];
    }
    eliminate(A_.data(), n, k, reach, end_[k]);
  }
  for (std::size_t i = n; i-- > 0;) {
    double sum = step_[i];
    for (std::size_t j = i + 1; j < end_[i]; ++j) sum -= A_[i * n + j] * step_[j];
    step_[i] = sum / A_[i * n + i];
    if (!std::isfinite(step_[i])) return false;
  }
  return true;
}

/// Into step_, by the natural map's generalised Jacobian at y_, which u_ belongs to.
bool ContactSolver::newton_step() {
  A_.assign(n_ * n_, 0.0);
  for (std::size_t c = 0; c < problem_.contacts; ++c) linearise_contact(c);
  for (std::size_t j = 0; j < bounds_.size(); ++j) linearise_joint_row(j);
  return solve_step();
}

/// One step from y_, with line search a shorter one where the whole one makes it worse. Returns the residual
/// there.
double ContactSolver::newton(bool with_line_search) {
  ++report_.newton_steps;
  const double before = residual_of(y_);
  if (!newton_step()) return before;
  const int halvings = with_line_search ? 6 : 1;
  double best = std::numeric_limits<double>::infinity();
  double factor = 1.0, best_factor = 0.0;
  for (int i = 0; i < halvings; ++i, factor *= 0.5) {
    for (std::size_t k = 0; k < n_; ++k) trial_[k] = y_[k] + factor * step_[k];
    const double residual = residual_of(trial_);
    if (residual < best) best = residual, best_factor = factor;
    if (residual < before) break;
  }
  for (std::size_t k = 0; k < n_; ++k) y_[k] += best_factor * step_[k];
  return best;
}

/// Newton's steps from y_ as long as they help. @return whether the best found is good enough.
bool ContactSolver::polish(int steps) {
  double last = std::numeric_limits<double>::infinity();
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
    for (int k = 0; k < kSweepsBetween; ++k, ++report_.sweeps) sweep();
    swept_ = y_;
    rho_ = kRho[static_cast<std::size_t>(i)];
    done = polish(kSweptSteps);
    y_ = swept_;
  }
  return done;
}

/// Whether the best is as good as rounding lets it be, though not as good as asked: by the problem's own
/// figures as well as by the scaled ones.
bool ContactSolver::is_rounding() {
  const double most = (report_.rounds < kLate ? kMostRounding : kMostLateRounding) * settings_.tolerance;
  if (!(report_.residual <= most)) return false;
  double worst = 0.0;
  for (std::size_t i = 0; i < n_; ++i) {
    if (scale_[i] == 0.0) continue;
    double sum = std::abs(b_[i]);
    for (std::size_t k = columns_[i].first; k < columns_[i].end; ++k)
      sum += std::abs(W_[i * n_ + k] * best_[k]);
    worst = std::max(worst, sum / scale_[i]);
  }
  if (!(report_.residual <= kRounding * worst)) return false;
  for (std::size_t i = 0; i < n_; ++i) trial_[i] = best_[i] * scale_[i];
  return natural_residual(problem_, trial_, step_) <= most;
}

/// Along the path of softened problems, and off it to the solution where it is near enough.
bool ContactSolver::follow_path(const ContactPath::Way& way) {
  rho_ = 1.0;
  if (!path_.start({problem_.contacts, problem_.friction, bounds_, W_, b_}, way)) return false;
  double next = kFirstPolish;
  while (path_.linear_solves() < way.most_solves && path_.advance()) {
    const double softness = path_.softness();
    if (softness > kLostSoftness) break;
    if (softness > next) continue;
    next = softness * kPolishAgain;
    std::copy(path_.y().begin(), path_.y().end(), y_.begin());
    if (keep_better(residual_of(y_)) || polish(settings_.newton_steps)) break;
  }
  report_.newton_steps += path_.linear_solves();
  return report_.residual <= settings_.tolerance;
}

/// [0, 1), xorshift64.
double ContactSolver::draw() {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return static_cast<double>(random_ >> 11) * 0x1p-53;
}

/// The solution if contacts were to open, stick or slip as drawn.
void ContactSolver::draw_statuses(double share_kept) {
  for (Status& status : status_) {
    if (draw() < share_kept) continue;
    const double which = draw();
    status = which < 0.3 ? Status::open : which < 0.7 ? Status::stick : Status::slip;
  }
  update_velocities(y_);
  if (newton_step())
    for (std::size_t i = 0; i < n_; ++i) y_[i] += step_[i];
  status_.assign(problem_.contacts, Status::by_value);
}

void ContactSolver::draw_values() {
  double largest = 0.0;
  for (const double y : best_) largest = std::max(largest, std::abs(y));
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double normal = draw() < 0.3 ? 0.0 : draw() * largest;
    const double radius = problem_.friction[c] * normal;
    const double t1 = (2.0 * draw() - 1.0) * radius, t2 = (2.0 * draw() - 1.0) * radius;
    y_[3 * c] = normal, y_[3 * c + 1] = t1, y_[3 * c + 2] = t2;
  }
}

void ContactSolver::start_anew(int round) {
  const bool from_best = round % 2 == 0;
  for (std::size_t i = 0; i < n_; ++i) y_[i] = from_best ? best_[i] : 0.0;
  switch (round / 2 % 4) {
    case 0:
      return draw_statuses(0.0);
    case 1:
      return draw_statuses(0.5);
    case 2:
      return draw_statuses(0.8);
    default:
      return draw_values();
  }
}

bool ContactSolver::keep_better(double residual) {
  if (residual < report_.residual) report_.residual = residual, best_ = y_;
  return report_.residual <= settings_.tolerance;
}

SolveReport ContactSolver::solve(const ContactProblem& problem, std::span<double> x) {
  load(problem, x);
  best_ = y_;
  report_.residual = residual_of(y_);
  const bool with_newton = n_ <= settings_.most_newton_rows;
  bool done = report_.residual <= settings_.tolerance;
  for (int round = 0; round < settings_.rounds && !done; ++round) {
    report_.rounds = round + 1;
    rho_ = kRho[static_cast<std::size_t>(round) % kRho.size()];
    if (round > 0 && with_newton) {
      if (is_rounding()) {
        done = true;
        break;
      }
      const Plan plan = plan_of(round);
      if (plan.round == Round::path) {
        done = follow_path(*plan.way);
        continue;
      }
      if (plan.round == Round::sweeps) {
        y_ = best_;
        done = sweep_and_polish(kSweptTries);
        continue;
      }
      start_anew(round);
      if (plan.round == Round::drawn_sweeps) {
        done = sweep_and_polish(1);
        continue;
      }
    }
    for (int i = 0; i < settings_.sweeps; ++i, ++report_.sweeps) sweep();
    done = keep_better(residual_of(y_));
    if (!with_newton) continue;
    // Where steps that get better all the time lead nowhere, those that need not may.
    const bool with_line_search = round % 4 < 2;
    const int steps = with_line_search ? settings_.newton_steps : 3 * settings_.newton_steps;
    for (int i = 0; i < steps && !done; ++i) done = keep_better(newton(with_line_search));
  }
  if (done && with_newton) {
    // One more step pays: it converges quadratically, and what goes on as it was is then held by the same
    // impulses for a long time.
    rho_ = 1.0;
    y_ = best_;
    keep_better(newton(false));
  }
  for (std::size_t i = 0; i < n_; ++i) x[i] = best_[i] * scale_[i];
  report_.converged = done;
  return report_;
}

}  // namespace touchstone::physics
