#include "touchstone/physics/convex_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/physics/contact_laws.hpp"

namespace touchstone::physics {
namespace {

// R beside a contact's own W: soft at first, since that takes fewest steps, then harder from round to round,
// so that few of them take it out. Far above rounding, as impulses are differences of velocities over R.
constexpr double kFirstSoftness = 1e-2, kHarder = 0.03, kSoftness = 1e-5;
// A round need not be solved better than to this share of the least that was left before it.
constexpr double kInexact = 0.01;
// The softness of contacts that contradict each other: it stays, and says how hard they press.
constexpr double kContradictorySoftness = 1e-3;
constexpr int kMostRounds = 20, kMostSteps = 40;
constexpr int kSoftRounds = 3;
constexpr double kFarBeyond = 1e4;
// A round that leaves more than this share of the residual of the one before brings nothing.
constexpr double kStuck = 0.7;
// What a step's work counts beside factoring: of a contact whose blocks are added, of a row.
constexpr double kAssembly = 450.0, kRowWork = 60.0;
// Slopes along a step below this share of the first count as 0.
constexpr double kFlat = 1e-3;
constexpr int kMostSearches = 20;

/// The projection on the cone, and where asked its derivative (symmetric, 3 x 3, row by row).
void project_on_cone(double friction, const double* y, double* p, double* derivative) {
  const double t = length_of(y[1], y[2]);
  if (t <= friction * y[0]) {
    std::copy(y, y + 3, p);
    if (derivative != nullptr)
      for (int i = 0; i < 9; ++i) derivative[i] = i % 4 == 0 ? 1.0 : 0.0;
    return;
  }
  if (friction * t <= -y[0]) {
    p[0] = p[1] = p[2] = 0.0;
    if (derivative != nullptr) std::fill(derivative, derivative + 9, 0.0);
    return;
  }
  const double share = 1.0 / (1.0 + friction * friction), e1 = y[1] / t, e2 = y[2] / t;
  p[0] = (y[0] + friction * t) * share;
  p[1] = friction * p[0] * e1;
  p[2] = friction * p[0] * e2;
  if (derivative == nullptr) return;
  const double across = friction * p[0] / t, along = friction * friction * share;
  derivative[0] = share;
  derivative[1] = derivative[3] = friction * share * e1;
  derivative[2] = derivative[6] = friction * share * e2;
  derivative[4] = along * e1 * e1 + across * e2 * e2;
  derivative[8] = along * e2 * e2 + across * e1 * e1;
  derivative[5] = derivative[7] = (along - across) * e1 * e2;
}

}  // namespace

void ConvexContacts::reserve(std::size_t units, std::size_t rows, std::size_t widest) {
  cholesky_.reserve(units, rows, widest);
  pairs_.reserve(rows);
  for (auto* vector : {&first_, &first_mass_}) vector->reserve(units + 1);
  for (auto* vector : {&scale_, &slip_, &anchor_, &gamma_, &u_, &du_, &best_}) vector->reserve(rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->reserve(units * widest);
  blocks_.reserve(6 * widest);
  for (auto* vector : {&stiffness_, &last_stiffness_}) vector->reserve(3 * rows);
}

/// w: the largest diagonal entry of W of each block.
void ConvexContacts::find_scales() {
  const auto own = [&](std::size_t row) {
    const SparseContacts::Row& r = problem_.rows[row];
    double sum = 0.0;
    for (int i = 0; i < r.count; ++i)
      for (std::size_t k = 0; k < problem_.sizes[r.units[i]]; ++k)
        sum += problem_.J[r.first[i] + k] * problem_.Y[r.first[i] + k];
    return sum;
  };
  scale_.clear();
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    scale_.push_back(std::max({own(3 * c), own(3 * c + 1), own(3 * c + 2)}));
  for (std::size_t r = 3 * problem_.contacts; r < problem_.rows.size(); ++r) scale_.push_back(own(r));
}

void ConvexContacts::find_pairs() {
  pairs_.clear();
  for (const SparseContacts::Row& row : problem_.rows) {
    if (row.count < 2) continue;
    const auto [a, b] = std::minmax(row.units[0], row.units[1]);
    if (pairs_.empty() || pairs_.back() != BlockCholesky::Pair(a, b)) pairs_.emplace_back(a, b);
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  cholesky_.analyse(problem_.sizes, pairs_);
}

void ConvexContacts::load(const SparseContacts& problem, std::span<const double> x) {
  problem_ = problem;
  report_ = {};
  first_.clear();
  first_mass_.clear();
  std::size_t rates = 0, entries = 0, widest = 0;
  for (const std::size_t size : problem.sizes) {
    first_.push_back(rates);
    first_mass_.push_back(entries);
    rates += size;
    entries += size * size;
    widest = std::max(widest, size);
  }
  const std::size_t rows = problem.rows.size();
  for (auto* vector : {&anchor_, &gamma_, &u_, &du_, &best_}) vector->resize(rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->resize(rates);
  blocks_.resize(6 * widest);
  slip_.resize(problem.contacts);
  std::copy(x.begin(), x.end(), anchor_.begin());
  is_factored_ = false;
  find_scales();
  find_pairs();
}

/// V: the rates that impulses give.
void ConvexContacts::spread(std::span<const double> impulses, std::vector<double>& V) const {
  std::fill(V.begin(), V.end(), 0.0);
  for (std::size_t r = 0; r < problem_.rows.size(); ++r) {
    const SparseContacts::Row& row = problem_.rows[r];
    if (impulses[r] == 0.0) continue;
    for (int i = 0; i < row.count; ++i) {
      double* const v = &V[first_[row.units[i]]];
      const double* const y = &problem_.Y[row.first[i]];
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) v[k] += y[k] * impulses[r];
    }
  }
}

/// u = J V (+ b).
void ConvexContacts::find_velocities(const std::vector<double>& V, std::vector<double>& u,
                                     bool with_b) const {
  for (std::size_t r = 0; r < problem_.rows.size(); ++r) {
    const SparseContacts::Row& row = problem_.rows[r];
    double sum = with_b ? problem_.b[r] : 0.0;
    for (int i = 0; i < row.count; ++i) {
      const double* const v = &V[first_[row.units[i]]];
      const double* const j = &problem_.J[row.first[i]];
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) sum += j[k] * v[k];
    }
    u[r] = sum;
  }
}

/// The impulses that velocities u call for.
void ConvexContacts::project(const std::vector<double>& u) {
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double R = softness_ * scale_[c];
    double y[3] = {0.0, 0.0, 0.0};
    if (R > 0.0) {
      for (std::size_t i = 0; i < 3; ++i) y[i] = anchor_[3 * c + i] - u[3 * c + i] / R;
      y[0] -= slip_[c] / R;
    }
    project_on_cone(problem_.friction[c], y, &gamma_[3 * c], nullptr);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double R = softness_ * scale_[problem_.contacts + j];
    gamma_[r] = R > 0.0 ? clamped(anchor_[r] - u[r] / R, problem_.bounds[j]) : 0.0;
  }
}

/// M V - J^T gamma.
void ConvexContacts::find_gradient() {
  for (std::size_t i = 0; i < problem_.sizes.size(); ++i) {
    const std::size_t n = problem_.sizes[i];
    const double* const M = &problem_.masses[first_mass_[i]];
    for (std::size_t r = 0; r < n; ++r) {
      double sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) sum += M[r * n + k] * V_[first_[i] + k];
      gradient_[first_[i] + r] = sum;
    }
  }
  for (std::size_t r = 0; r < problem_.rows.size(); ++r) {
    const SparseContacts::Row& row = problem_.rows[r];
    if (gamma_[r] == 0.0) continue;
    for (int i = 0; i < row.count; ++i) {
      double* const g = &gradient_[first_[row.units[i]]];
      const double* const j = &problem_.J[row.first[i]];
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) g[k] -= j[k] * gamma_[r];
    }
  }
}

/// J^T G J of rows that act on the same units. @param G count x count, symmetric.
void ConvexContacts::add_rows(std::size_t first, std::size_t count, const double* G) {
  const SparseContacts::Row* const rows = &problem_.rows[first];
  for (int i = 0; i < rows->count; ++i) {
    const std::uint32_t unit = rows->units[i];
    const std::size_t n = problem_.sizes[unit];
    for (std::size_t r = 0; r < count; ++r)
      for (std::size_t k = 0; k < n; ++k) {
        double sum = 0.0;
        for (std::size_t s = 0; s < count; ++s) sum += G[r * count + s] * problem_.J[rows[s].first[i] + k];
        blocks_[r * n + k] = sum;
      }
    for (int other = 0; other < rows->count; ++other) {
      const std::uint32_t with = rows->units[other];
      // A pair's block is kept once, its rows those of the unit that is eliminated later.
      bool is_transposed = false;
      double* block = nullptr;
      if (other == i)
        block = cholesky_.diagonal(unit);
      else
        block = cholesky_.block(with, unit, is_transposed);
      if (is_transposed) continue;
      const std::size_t height = problem_.sizes[with];
      for (std::size_t r = 0; r < count; ++r) {
        const double* const j = &problem_.J[rows[r].first[other]];
        for (std::size_t h = 0; h < height; ++h)
          for (std::size_t k = 0; k < n; ++k) block[h * n + k] += j[h] * blocks_[r * n + k];
      }
    }
  }
}

/// G of every block at the velocities u_, 0 where nothing presses. @return whether it is as it was when the
/// system was last factored.
bool ConvexContacts::find_stiffness() {
  stiffness_.swap(last_stiffness_);
  const std::size_t contacts = problem_.contacts;
  stiffness_.assign(9 * contacts + problem_.bounds.size(), 0.0);
  for (std::size_t c = 0; c < contacts; ++c) {
    const double R = softness_ * scale_[c];
    if (!(R > 0.0)) continue;
    double y[3], p[3];
    double* const G = &stiffness_[9 * c];
    for (std::size_t i = 0; i < 3; ++i) y[i] = anchor_[3 * c + i] - u_[3 * c + i] / R;
    y[0] -= slip_[c] / R;
    project_on_cone(problem_.friction[c], y, p, G);
    for (std::size_t i = 0; i < 9; ++i) G[i] /= R;
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * contacts + j;
    const double R = softness_ * scale_[contacts + j];
    if (!(R > 0.0)) continue;
    const double y = anchor_[r] - u_[r] / R;
    if (y >= problem_.bounds[j].lower && y <= problem_.bounds[j].upper)
      stiffness_[9 * contacts + j] = 1.0 / R;
  }
  return is_factored_ && stiffness_ == last_stiffness_;
}

/// M + J^T G J.
void ConvexContacts::assemble() {
  cholesky_.clear();
  for (std::uint32_t i = 0; i < problem_.sizes.size(); ++i)
    std::copy_n(&problem_.masses[first_mass_[i]], problem_.sizes[i] * problem_.sizes[i],
                cholesky_.diagonal(i));
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (stiffness_[9 * c] > 0.0) add_rows(3 * c, 3, &stiffness_[9 * c]);
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const double G = stiffness_[9 * problem_.contacts + j];
    if (G > 0.0) add_rows(3 * problem_.contacts + j, 1, &G);
  }
}

/// Of the potential along step_, and how that changes.
double ConvexContacts::slope_at(double along, double& curvature) {
  double slope = 0.0;
  curvature = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double R = softness_ * scale_[c];
    if (!(R > 0.0)) continue;
    const double* const du = &du_[3 * c];
    double y[3], p[3], G[9];
    for (std::size_t i = 0; i < 3; ++i) y[i] = anchor_[3 * c + i] - (u_[3 * c + i] + along * du[i]) / R;
    y[0] -= slip_[c] / R;
    project_on_cone(problem_.friction[c], y, p, G);
    slope -= (p[0] * du[0] + p[1] * du[1]) + p[2] * du[2];
    for (std::size_t i = 0; i < 3; ++i)
      curvature += du[i] * ((G[3 * i] * du[0] + G[3 * i + 1] * du[1]) + G[3 * i + 2] * du[2]) / R;
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double R = softness_ * scale_[problem_.contacts + j];
    if (!(R > 0.0)) continue;
    const double y = anchor_[r] - (u_[r] + along * du_[r]) / R, p = clamped(y, problem_.bounds[j]);
    slope -= p * du_[r];
    if (p == y) curvature += du_[r] * du_[r] / R;
  }
  return slope;
}

/// Where along step_ the potential is least: its slope grows, so the root is between two ends, found by
/// Newton's method, by halves where that leaves them.
double ConvexContacts::line_search() {
  double a = 0.0, c = 0.0;  // of 1/2 V^T M V
  for (std::size_t i = 0; i < problem_.sizes.size(); ++i) {
    const std::size_t n = problem_.sizes[i];
    const double* const M = &problem_.masses[first_mass_[i]];
    for (std::size_t r = 0; r < n; ++r) {
      double by_step = 0.0;
      for (std::size_t k = 0; k < n; ++k) by_step += M[r * n + k] * step_[first_[i] + k];
      a += step_[first_[i] + r] * by_step;
      c += V_[first_[i] + r] * by_step;
    }
  }
  double curvature = 0.0;
  const double start = std::abs(c + slope_at(0.0, curvature));
  double low = 0.0, high = 1.0, along = 1.0;
  for (int i = 0; i < kMostSearches; ++i) {
    const double slope = c + a * along + slope_at(along, curvature);
    if (std::abs(slope) <= kFlat * start) break;
    if (slope < 0.0) {
      if (along >= 1.0) break;  // beyond a whole step the model says nothing
      low = along;
    } else {
      high = along;
    }
    const double next = along - slope / (a + curvature);
    along = next > low && next < high ? next : 0.5 * (low + high);
  }
  return along;
}

/// How far velocities by the impulses are from those of V [m/s], at most: J M^-1 of the gradient.
double ConvexContacts::missed() const {
  double worst = 0.0;
  for (const SparseContacts::Row& row : problem_.rows) {
    double sum = 0.0;
    for (int i = 0; i < row.count; ++i)
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k)
        sum += problem_.Y[row.first[i] + k] * gradient_[first_[row.units[i]] + k];
    worst = worse_of(worst, std::abs(sum));
  }
  return worst;
}

/// Of V, for the anchor and slips as they are; u_ and gamma_ are those of V in the end.
ConvexContacts::Outcome ConvexContacts::minimise(double tolerance, WorkBudget& budget) {
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostSteps; ++i) {
    find_velocities(V_, u_, true);
    project(u_);
    find_gradient();
    const double miss = missed();
    if (miss <= tolerance) return Outcome::solved;
    if (!std::isfinite(miss)) return Outcome::stuck;
    if (budget.is_spent()) return Outcome::spent;
    if (!find_stiffness()) {
      assemble();
      is_factored_ = cholesky_.factor();
      if (!is_factored_) return Outcome::stuck;
      budget.spend(cholesky_.work() + kAssembly * static_cast<double>(problem_.contacts));
    }
    for (std::size_t k = 0; k < gradient_.size(); ++k) step_[k] = -gradient_[k];
    cholesky_.solve(step_, first_);
    find_velocities(step_, du_, false);
    budget.spend(kRowWork * static_cast<double>(problem_.rows.size()));
    ++report_.newton_steps;
    const double along = line_search();
    double most = 0.0;
    for (std::size_t k = 0; k < V_.size(); ++k) V_[k] += along * step_[k];
    for (const double du : du_) most = std::max(most, std::abs(du));
    if (most <= tolerance * 1e-3 && most >= last) return Outcome::solved;  // rounding
    last = most;
  }
  return Outcome::spent;
}

/// The natural residual, by the rates that x gives; u_ are the velocities.
double ConvexContacts::residual_of(std::span<const double> x) {
  spread(x, trial_V_);
  find_velocities(trial_V_, u_, true);
  double worst = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (scale_[c] > 0.0)
      worst = worse_of(worst, contact_residual(scale_[c], problem_.friction[c], &x[3 * c], &u_[3 * c]));
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double w = scale_[problem_.contacts + j];
    if (w > 0.0) worst = worse_of(worst, w * std::abs(x[r] - clamped(x[r] - u_[r] / w, problem_.bounds[j])));
  }
  return worst;
}

/// Impulses far beyond what stops everything: rounds add to them what the velocities lack, and lack it still.
bool ConvexContacts::is_growing() const {
  double speed = 0.0, most = 0.0;
  for (const double b : problem_.b) speed = std::max(speed, std::abs(b));
  for (std::size_t r = 0; r < gamma_.size(); ++r)
    most = std::max(
        most, scale_[r < 3 * problem_.contacts ? r / 3 : r - 2 * problem_.contacts] * std::abs(gamma_[r]));
  return most > kFarBeyond * speed;
}

/// The soft answer around 0.
void ConvexContacts::soften(double tolerance, WorkBudget& budget) {
  softness_ = kContradictorySoftness;
  std::fill(anchor_.begin(), anchor_.end(), 0.0);
  for (int round = 0; round < kSoftRounds; ++round) {
    if (minimise(tolerance, budget) != Outcome::solved) return;
    report_.is_contradictory = true;
    best_ = gamma_;
    report_.residual = residual_of(gamma_);
    for (std::size_t c = 0; c < problem_.contacts; ++c)
      slip_[c] = problem_.friction[c] * length_of(u_[3 * c + 1], u_[3 * c + 2]);
  }
}

ConvexReport ConvexContacts::solve(const SparseContacts& problem, std::span<double> x, double tolerance,
                                   WorkBudget& budget) {
  load(problem, x);
  softness_ = kFirstSoftness;
  report_.residual = residual_of(anchor_);
  best_ = anchor_;
  V_ = trial_V_;
  double last = report_.residual;
  bool is_first = true;  // what a round solves takes energy; what there was to start from may give some
  for (int round = 0; round < kMostRounds && !(report_.residual <= tolerance); ++round) {
    for (std::size_t c = 0; c < problem_.contacts; ++c)
      slip_[c] = problem_.friction[c] * length_of(u_[3 * c + 1], u_[3 * c + 2]);
    const Outcome outcome = minimise(std::max(0.1 * tolerance, kInexact * last), budget);
    const double residual = residual_of(gamma_);
    if (outcome != Outcome::solved) break;
    if (is_first || residual < report_.residual) report_.residual = residual, best_ = gamma_;
    is_first = false;
    if (softness_ == kSoftness && !(residual <= kStuck * last)) break;
    softness_ = std::max(kSoftness, kHarder * softness_);
    last = std::min(last, residual);
    anchor_ = gamma_;
  }
  report_.converged = report_.residual <= tolerance;
  if (!report_.converged && is_growing()) soften(tolerance, budget);
  std::copy(best_.begin(), best_.end(), x.begin());
  return report_;
}

}  // namespace touchstone::physics
