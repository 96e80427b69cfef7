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

// Work of a step beside factoring, in operations: of a contact whose blocks are added, of a row.
constexpr double kAssembly = 450.0, kRowWork = 60.0;
// Slopes along a step below this share of the first count as 0.
constexpr double kFlat = 1e-3;
constexpr int kMostSearches = 20;

constexpr std::size_t kBodyRates = 6;  // of most units: unrolled

/// K = D^T G D of a contact's three directions, which are the first parts of its rows of J.
Matrix3 stiffness_in_world(const double* d1, const double* d2, const double* d3, const double* G) {
  double GD[3][3];
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k)
      GD[r][k] = (G[3 * r] * d1[k] + G[3 * r + 1] * d2[k]) + G[3 * r + 2] * d3[k];
  Matrix3 K;
  for (int r = 0; r < 3; ++r)
    for (int k = r; k < 3; ++k) K(r, k) = K(k, r) = (d1[r] * GD[0][k] + d2[r] * GD[1][k]) + d3[r] * GD[2][k];
  return K;
}

/// B += sign [1; [a]x] K [1, -[b]x], 6 x 6: rows of one body with the lever a, columns of another with b.
void add_lever_block(double* __restrict B, const Matrix3& K, const Vector3& a, const Vector3& b,
                     double sign) {
  const auto at = [](int row, int column) {
    return static_cast<std::size_t>(row) * kBodyRates + static_cast<std::size_t>(column);
  };
  Matrix3 Kb;  // -K [b]x
  for (int r = 0; r < 3; ++r) {
    const Vector3 row(K(r, 0), K(r, 1), K(r, 2)), turned = cross(b, row);
    for (int k = 0; k < 3; ++k) Kb(r, k) = turned[k];
  }
  for (int c = 0; c < 3; ++c) {
    const Vector3 of_K = cross(a, Vector3(K(0, c), K(1, c), K(2, c))),
                  of_Kb = cross(a, Vector3(Kb(0, c), Kb(1, c), Kb(2, c)));
    for (int r = 0; r < 3; ++r) {
      B[at(r, c)] += sign * K(r, c);
      B[at(r, c + 3)] += sign * Kb(r, c);
      B[at(r + 3, c)] += sign * of_K[r];
      B[at(r + 3, c + 3)] += sign * of_Kb[r];
    }
  }
}

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
  for (std::size_t r = 0; r < problem_.rows.size(); ++r)
    if (impulses[r] != 0.0) add(problem_.rows[r], problem_.Y, impulses[r], V);
}

/// u = J V (+ b).
void ConvexContacts::find_velocities(const std::vector<double>& V, std::vector<double>& u,
                                     bool with_b) const {
  for (std::size_t r = 0; r < problem_.rows.size(); ++r)
    u[r] = product(problem_.rows[r], problem_.J, V, with_b ? problem_.b[r] : 0.0);
}

/// The impulses that a contact's velocities call for, were there no cone; none where nothing moves it.
void ConvexContacts::ask(std::size_t contact, const double* u, double* y) const {
  const double hardness = hardness_[contact];
  for (std::size_t i = 0; i < 3; ++i)
    y[i] = hardness > 0.0 ? anchor_[3 * contact + i] - u[i] * hardness : 0.0;
  y[0] -= slip_[contact] * hardness;
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

/// The impulses that velocities u call for.
void ConvexContacts::project(const std::vector<double>& u) {
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    double y[3];
    ask(c, &u[3 * c], y);
    project_on_cone(problem_.friction[c], y, length_of(y[1], y[2]), &gamma_[3 * c]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double hardness = hardness_[problem_.contacts + j];
    gamma_[r] =
        hardness > 0.0 ? clamped(anchor_share_[j] * anchor_[r] - u[r] * hardness, problem_.bounds[j]) : 0.0;
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
  for (std::size_t r = 0; r < problem_.rows.size(); ++r)
    if (gamma_[r] != 0.0) add(problem_.rows[r], problem_.J, -gamma_[r], gradient_);
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

/// add_rows() of a contact between bodies, in the world's axes: a third of the products.
void ConvexContacts::add_contact(std::size_t contact, const double* G) {
  const SparseContacts::Levers& levers = problem_.levers[contact];
  const SparseContacts::Row* const rows = &problem_.rows[3 * contact];
  const double* const J = problem_.J.data();
  const Matrix3 K = stiffness_in_world(J + rows[0].first[0], J + rows[1].first[0], J + rows[2].first[0], G);
  for (int i = 0; i < rows->count; ++i)
    add_lever_block(cholesky_.diagonal(rows->units[i]), K, levers.of[i], levers.of[i], 1.0);
  if (rows->count < 2) return;
  bool is_transposed = false;  // its rows are those of the unit that is eliminated later
  double* const block = cholesky_.block(rows->units[0], rows->units[1], is_transposed);
  const int row = is_transposed ? 1 : 0;
  add_lever_block(block, K, levers.of[row], levers.of[1 - row], -1.0);
}

/// G of every block at the velocities u_, 0 where nothing presses. @return whether it is as it was when the
/// system was last factored.
bool ConvexContacts::find_stiffness() {
  stiffness_.swap(last_stiffness_);
  const std::size_t contacts = problem_.contacts;
  stiffness_.assign(9 * contacts + problem_.bounds.size(), 0.0);
  for (std::size_t c = 0; c < contacts; ++c) {
    if (!(hardness_[c] > 0.0)) continue;
    double y[3];
    ask(c, &u_[3 * c], y);
    slope_of_projection(problem_.friction[c], y, hardness_[c], &stiffness_[9 * c]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * contacts + j;
    const double hardness = hardness_[contacts + j];
    if (!(hardness > 0.0)) continue;
    const double y = anchor_share_[j] * anchor_[r] - u_[r] * hardness;
    if (y >= problem_.bounds[j].lower && y <= problem_.bounds[j].upper)
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
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    if (!(stiffness_[9 * c] > 0.0)) continue;
    if (!problem_.levers.empty() && problem_.levers[c].are_of_bodies)
      add_contact(c, &stiffness_[9 * c]);
    else
      add_rows(3 * c, 3, &stiffness_[9 * c]);
  }
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
    if (!(hardness_[c] > 0.0)) continue;
    const double* const du = &du_[3 * c];
    double u[3], y[3], p[3], change[3];
    for (std::size_t i = 0; i < 3; ++i) u[i] = u_[3 * c + i] + along * du[i];
    ask(c, u, y);
    change_of_projection(problem_.friction[c], y, du, p, change);
    slope -= (p[0] * du[0] + p[1] * du[1]) + p[2] * du[2];
    curvature += ((du[0] * change[0] + du[1] * change[1]) + du[2] * change[2]) * hardness_[c];
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double hardness = hardness_[problem_.contacts + j];
    if (!(hardness > 0.0)) continue;
    const double y = anchor_share_[j] * anchor_[r] - (u_[r] + along * du_[r]) * hardness,
                 p = clamped(y, problem_.bounds[j]);
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
  // Newton's method within a bracket finds the root of the slope.
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

/// How far velocities by gamma_ are from those of V [m/s], at most: J M^-1 of the gradient.
double ConvexContacts::missed() const {
  double worst = 0.0;
  for (const SparseContacts::Row& row : problem_.rows)
    worst = worse_of(worst, std::abs(product(row, problem_.Y, gradient_, 0.0)));
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
      budget.spend(price_ * (cholesky_.work() + kAssembly * static_cast<double>(problem_.contacts)));
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
