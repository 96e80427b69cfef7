#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/cone_projection.hpp"
#include "touchstone/physics/solver/convex_contacts.hpp"

// One convex problem of ConvexContacts: its gradient, its stiffness M + J^T G J, and Newton's method with
// exact line search. Which problems are solved, and when that is over: convex_contacts.cpp.

namespace touchstone::physics {
namespace {

// Work of a step beside factoring, in multiplications: of a contact whose blocks are added, between bodies by
// its levers and of others by their rows; of a row.
constexpr double kAssembly = 160.0, kRowsAssembly = 450.0, kRowWork = 40.0;
// Slopes along a step below this share of the first count as 0.
constexpr double kFlat = 1e-3;
constexpr int kMostSearches = 20;

constexpr std::size_t kBodyRates = 6;  // of most units: unrolled

/// B += [j1 j2 j3] blocks, of a contact between bodies.
void add_contact_block(double* __restrict B, const double* j1, const double* j2, const double* j3,
                       const double* __restrict blocks) {
  for (std::size_t h = 0; h < kBodyRates; ++h)
    for (std::size_t k = 0; k < kBodyRates; ++k)
      B[h * kBodyRates + k] +=
          (j1[h] * blocks[k] + j2[h] * blocks[kBodyRates + k]) + j3[h] * blocks[2 * kBodyRates + k];
}

}  // namespace

/// Of a row of J or Y.
void ConvexContacts::add(const SparseContacts::Row& row, std::span<const double> of, double factor,
                         std::vector<double>& to) const {
  for (int i = 0; i < row.count; ++i) {
    double* const t = &to[first_[row.units[i]]];
    const double* const values = &of[row.first[i]];
    const std::size_t n = problem_.sizes[row.units[i]];
    if (n == kBodyRates)
      for (std::size_t k = 0; k < kBodyRates; ++k) t[k] += values[k] * factor;
    else
      for (std::size_t k = 0; k < n; ++k) t[k] += values[k] * factor;
  }
}

double ConvexContacts::product(const SparseContacts::Row& row, std::span<const double> of,
                               const std::vector<double>& with, double start) const {
  double sum = start;
  for (int i = 0; i < row.count; ++i) {
    const double* const w = &with[first_[row.units[i]]];
    const double* const values = &of[row.first[i]];
    const std::size_t n = problem_.sizes[row.units[i]];
    if (n == kBodyRates)
      for (std::size_t k = 0; k < kBodyRates; ++k) sum += values[k] * w[k];
    else
      for (std::size_t k = 0; k < n; ++k) sum += values[k] * w[k];
  }
  return sum;
}

/// V: the rates that impulses give.
void ConvexContacts::spread(std::span<const double> impulses, std::vector<double>& V) const {
  std::fill(V.begin(), V.end(), 0.0);
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (body_contacts_[c].count > 0) add_impulse(body_contacts_[c], &impulses[3 * c], V.data());
  divide_by_masses(V);
  for_other_rows([&](std::size_t r) {
    if (impulses[r] != 0.0) add(problem_.rows[r], problem_.Y, impulses[r], V);
  });
}

/// M^-1 of the bodies'; others are left.
void ConvexContacts::divide_by_masses(std::vector<double>& V) const {
  for (std::size_t i = 0; i < problem_.sizes.size(); ++i) {
    if (problem_.bodies.empty() || !(problem_.bodies[i].mass > 0.0)) continue;
    double* const v = &V[first_[i]];
    const Vector3 w = rotate(problem_.bodies[i].inverse_inertia_W, vector_at(v + 3));
    for (int k = 0; k < 3; ++k) v[k] /= problem_.bodies[i].mass, v[k + 3] = w[k];
  }
}

/// u = J V (+ b).
void ConvexContacts::find_velocities(const std::vector<double>& V, std::vector<double>& u,
                                     bool with_b) const {
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const BodyContact& contact = body_contacts_[c];
    if (contact.count == 0) continue;
    const Vector3 v = relative_velocity(contact, V.data());
    for (std::size_t i = 0; i < 3; ++i)
      u[3 * c + i] = (with_b ? problem_.b[3 * c + i] : 0.0) + dot(contact.directions[i], v);
  }
  for_other_rows(
      [&](std::size_t r) { u[r] = product(problem_.rows[r], problem_.J, V, with_b ? problem_.b[r] : 0.0); });
}

void ConvexContacts::set_softness(double softness) {
  softness_ = softness;
  hardness_.resize(scale_.size());
  for (std::size_t i = 0; i < scale_.size(); ++i)
    hardness_[i] = scale_[i] > 0.0 ? 1.0 / (softness * scale_[i]) : 0.0;
  // A compliant row's law is soft by itself: the proximal point's share of its softness goes with the anchor.
  anchor_share_.assign(problem_.bounds.size(), 1.0);
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const double compliance = problem_.compliance_of(j);
    double& hardness = hardness_[problem_.contacts + j];
    if (compliance == 0.0 || hardness == 0.0) continue;
    const double soft = 1.0 / hardness;
    hardness = 1.0 / (soft + compliance);
    anchor_share_[j] = soft * hardness;
  }
}

/// The impulses that velocities u call for: asked_ were there no cone, none where nothing moves a contact.
void ConvexContacts::project(const std::vector<double>& u) {
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double hardness = hardness_[c];
    double* const y = &asked_[3 * c];
    for (std::size_t i = 0; i < 3; ++i)
      y[i] = hardness > 0.0 ? anchor_[3 * c + i] - u[3 * c + i] * hardness : 0.0;
    y[0] -= slip_[c] * hardness;
    project_on_cone(problem_.friction[c], y, length_of(y[1], y[2]), &gamma_[3 * c]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double hardness = hardness_[problem_.contacts + j];
    asked_[r] = hardness > 0.0 ? anchor_share_[j] * anchor_[r] - u[r] * hardness : 0.0;
    gamma_[r] = hardness > 0.0 ? clamped(asked_[r], problem_.bounds[j]) : 0.0;
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
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    if (body_contacts_[c].count == 0) continue;
    const double against[3] = {-gamma_[3 * c], -gamma_[3 * c + 1], -gamma_[3 * c + 2]};
    add_impulse(body_contacts_[c], against, gradient_.data());
  }
  for_other_rows([&](std::size_t r) {
    if (gamma_[r] != 0.0) add(problem_.rows[r], problem_.J, -gamma_[r], gradient_);
  });
}

/// J^T G J of rows that act on the same units. @param G count x count, symmetric.
void ConvexContacts::add_rows(std::size_t first, std::size_t count, const double* G) {
  const SparseContacts::Row* const rows = &problem_.rows[first];
  for (int i = 0; i < rows->count; ++i) {
    const std::uint32_t unit = rows->units[i];
    const std::size_t n = problem_.sizes[unit];
    // `blocks_` holds G J of this unit.
    for (std::size_t r = 0; r < count; ++r)
      for (std::size_t k = 0; k < n; ++k) {
        double sum = 0.0;
        for (std::size_t s = 0; s < count; ++s) sum += G[r * count + s] * problem_.J[rows[s].first[i] + k];
        blocks_[r * n + k] = sum;
      }
    const auto J = [&](std::size_t r, int side) { return &problem_.J[rows[r].first[side]]; };
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
      // J^T G J is added; contacts between free bodies have a routine of fixed size.
      const std::size_t height = problem_.sizes[with];
      if (count == 3 && n == kBodyRates && height == kBodyRates) {
        add_contact_block(block, J(0, other), J(1, other), J(2, other), blocks_.data());
        continue;
      }
      for (std::size_t r = 0; r < count; ++r)
        for (std::size_t h = 0; h < height; ++h)
          for (std::size_t k = 0; k < n; ++k) block[h * n + k] += J(r, other)[h] * blocks_[r * n + k];
    }
  }
}

/// J^T G J of the contacts between the same bodies from the first on. @return the next that is another's
std::size_t ConvexContacts::add_pair(std::size_t first) {
  const BodyContact& pair = body_contacts_[first];
  stiffness_of_pair_.clear();
  bool is_any = false;
  std::size_t c = first;
  for (; c < problem_.contacts; ++c) {
    const BodyContact& contact = body_contacts_[c];
    if (contact.count != pair.count || contact.first[0] != pair.first[0] || contact.first[1] != pair.first[1])
      break;
    if (!(stiffness_[9 * c] > 0.0)) continue;
    stiffness_of_pair_.add(contact, &stiffness_[9 * c]);
    is_any = true;
  }
  if (!is_any) return c;
  const SparseContacts::Row& row = problem_.rows[3 * first];
  for (int side = 0; side < row.count; ++side)
    stiffness_of_pair_.write_own(side, cholesky_.diagonal(row.units[side]));
  if (row.count < 2) return c;
  bool is_transposed = false;  // its rows are those of the unit that is eliminated later
  double* const block = cholesky_.block(row.units[0], row.units[1], is_transposed);
  stiffness_of_pair_.write_both(!is_transposed, block);
  return c;
}

/// G of every block at the impulses asked_, 0 where nothing presses. @return whether it is as it was when the
/// system was last factored.
bool ConvexContacts::find_stiffness() {
  stiffness_.swap(last_stiffness_);
  const std::size_t contacts = problem_.contacts;
  stiffness_.assign(9 * contacts + problem_.bounds.size(), 0.0);
  for (std::size_t c = 0; c < contacts; ++c) {
    if (!(hardness_[c] > 0.0)) continue;
    slope_of_projection(problem_.friction[c], &asked_[3 * c], hardness_[c], &stiffness_[9 * c]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * contacts + j;
    const double hardness = hardness_[contacts + j];
    if (!(hardness > 0.0)) continue;
    if (asked_[r] >= problem_.bounds[j].lower && asked_[r] <= problem_.bounds[j].upper)
      stiffness_[9 * contacts + j] = hardness;
  }
  return is_factored_ && stiffness_ == last_stiffness_;
}

/// M + J^T G J.
void ConvexContacts::assemble() {
  cholesky_.clear();
  for (std::uint32_t i = 0; i < problem_.sizes.size(); ++i)
    std::copy_n(&problem_.masses[first_mass_[i]], problem_.sizes[i] * problem_.sizes[i],
                cholesky_.diagonal(i));
  for (std::size_t c = 0; c < problem_.contacts;) {
    if (body_contacts_[c].count > 0) {
      c = add_pair(c);
      continue;
    }
    if (stiffness_[9 * c] > 0.0) add_rows(3 * c, 3, &stiffness_[9 * c]);
    ++c;
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const double G = stiffness_[9 * problem_.contacts + j];
    if (G > 0.0) add_rows(3 * problem_.contacts + j, 1, &G);
  }
}

/// Of the potential along step_, and how that changes. From asked_.
double ConvexContacts::slope_at(double along, double& curvature) const {
  double slope = 0.0;
  curvature = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double hardness = hardness_[c], by = along * hardness;
    const double* const du = &du_[3 * c];
    const double* const asked = &asked_[3 * c];
    const double y[3] = {asked[0] - by * du[0], asked[1] - by * du[1], asked[2] - by * du[2]};
    const ConeSlope of = slope_along(problem_.friction[c], y, du);
    slope -= of.projection;
    curvature += of.change * hardness;
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double hardness = hardness_[problem_.contacts + j];
    if (!(hardness > 0.0)) continue;
    const double y = asked_[r] - (along * hardness) * du_[r], p = clamped(y, problem_.bounds[j]);
    slope -= p * du_[r];
    if (p == y) curvature += du_[r] * du_[r] * hardness;
  }
  return slope;
}

/// Where along step_ the potential is least: its slope grows, so the root is between two ends, found by
/// Newton's method, by halves where that leaves them.
double ConvexContacts::line_search() {
  double a = 0.0, c = 0.0;  // of 1/2 V^T M V
  // The quadratic part is summed unit by unit.
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
  // Newton's method within a bracket finds the root of the slope; at 0 it is the gradient's along the step.
  double curvature = 0.0;
  const double start = std::abs(sum_of_products(gradient_.data(), step_.data(), step_.size()));
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

/// How far velocities by gamma_ are from those of V [m/s], at most: J M^-1 of the gradient.
double ConvexContacts::missed() {
  trial_V_ = gradient_;
  divide_by_masses(trial_V_);
  double worst = 0.0;
  for (const BodyContact& contact : body_contacts_) {
    if (contact.count == 0) continue;
    const Vector3 v = relative_velocity(contact, trial_V_.data());
    for (const Vector3& direction : contact.directions) worst = worse_of(worst, std::abs(dot(direction, v)));
  }
  for_other_rows([&](std::size_t r) {
    worst = worse_of(worst, std::abs(product(problem_.rows[r], problem_.Y, gradient_, 0.0)));
  });
  return worst;
}

/// V_, the velocities that follow from it and the impulses that make it. The impulses after a whole step are
/// gamma_ - G J dV, since M (V + dV) = J^T of them; so V_ is always theirs, solved or not.
void ConvexContacts::go_along(double along) {
  for (std::size_t k = 0; k < V_.size(); ++k) V_[k] += along * step_[k];
  const auto go = [&](std::size_t r, double by_stiffness) {
    impulses_[r] += along * ((gamma_[r] - by_stiffness) - impulses_[r]);
    u_[r] += along * du_[r];
  };
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const double* const G = &stiffness_[9 * c];
    const double* const du = &du_[3 * c];
    for (std::size_t i = 0; i < 3; ++i)
      go(3 * c + i, (G[3 * i] * du[0] + G[3 * i + 1] * du[1]) + G[3 * i + 2] * du[2]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    go(r, stiffness_[9 * problem_.contacts + j] * du_[r]);
  }
}

/// Of V, for the anchor and slips as they are, by a step at least; u_ and gamma_ are those of V in the end,
/// impulses_ make it.
ConvexContacts::Outcome ConvexContacts::minimise(double tolerance, WorkBudget& budget, int most_steps) {
  double last = kInfinity;
  find_velocities(V_, u_, true);
  for (int i = 0;; ++i) {
    // The gradient decides whether V is good enough.
    project(u_);
    find_gradient();
    const double miss = missed();
    if (miss <= tolerance) return Outcome::solved;
    if (!std::isfinite(miss)) return Outcome::stuck;
    if (i == most_steps || (i > 0 && budget.is_spent())) return Outcome::spent;
    // The system is factored anew only if the stiffness has changed.
    if (!find_stiffness()) {
      assemble();
      is_factored_ = cholesky_.factor();
      if (!is_factored_) return Outcome::stuck;
      const auto others = static_cast<double>(other_contacts_);
      const auto of_bodies = static_cast<double>(problem_.contacts) - others;
      budget.spend(price_ * (cholesky_.work() + kAssembly * of_bodies + kRowsAssembly * others));
    }
    // Newton's step and the velocities along it are found.
    for (std::size_t k = 0; k < gradient_.size(); ++k) step_[k] = -gradient_[k];
    cholesky_.solve(step_, first_);
    find_velocities(step_, du_, false);
    budget.spend(price_ * kRowWork * static_cast<double>(problem_.rows.size()));
    ++report_.newton_steps;
    // A step of the size of rounding ends the search; else the line search sets its length.
    double most = 0.0;
    for (const double du : du_) most = worse_of(most, std::abs(du));
    if (!std::isfinite(most)) return Outcome::stuck;
    if (most <= tolerance * 1e-3 && most >= last) return Outcome::solved;  // rounding
    go_along(line_search());
    last = most;
  }
}

}  // namespace touchstone::physics
