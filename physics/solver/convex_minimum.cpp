#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/cone_lanes.hpp"
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

/// B += [j1 j2 j3] blocks, of a contact's rows over units of kBodyRates each.
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
  for (std::size_t i = 0; i < body_contacts_.size(); ++i)
    add_impulses(body_contacts_[i], lanes_at(&impulses[BodyContacts::kRows * i]), 1.0, V.data());
  divide_by_masses(V);
  for_other_rows([&](std::size_t r, std::size_t place) {
    if (impulses[place] != 0.0) add(problem_.rows[r], problem_.Y, impulses[place], V);
  });
}

/// M^-1 of the bodies'; others are left.
void ConvexContacts::divide_by_masses(std::vector<double>& V) const {
  for (std::size_t i = 0; i < problem_.sizes.size(); ++i) {
    if (problem_.bodies.empty() || !(problem_.bodies[i].mass > 0.0)) continue;
    double* const v = &V[first_[i]];
    const Vector3 w = rotate(problem_.bodies[i].inverse_inertia_W, Vector3(v[3], v[4], v[5]));
    for (int k = 0; k < 3; ++k) v[k] /= problem_.bodies[i].mass, v[k + 3] = w[k];
  }
}

/// u = J V (+ b).
void ConvexContacts::find_velocities(const std::vector<double>& V, std::vector<double>& u,
                                     bool with_b) const {
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const BodyContacts& contacts = body_contacts_[i];
    const std::size_t first = BodyContacts::kRows * i;
    ContactLanes v = along_directions(contacts, relative_velocities(contacts, V.data()));
    if (with_b) {
      const ContactLanes b = lanes_at(&b_[first]);
      v = {v.n + b.n, v.t1 + b.t1, v.t2 + b.t2};
    }
    put(v, &u[first]);
  }
  for_other_rows([&](std::size_t r, std::size_t place) {
    u[place] = product(problem_.rows[r], problem_.J, V, with_b ? b_[place] : 0.0);
  });
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
    double& hardness = hardness_[first_joint() + j];
    if (compliance == 0.0 || hardness == 0.0) continue;
    const double soft = 1.0 / hardness;
    hardness = 1.0 / (soft + compliance);
    anchor_share_[j] = soft * hardness;
  }
}

/// The impulses that velocities u call for: asked_ were there no cone, none where nothing moves a contact.
void ConvexContacts::project(const std::vector<double>& u) {
  const Four none = in_all(0.0);
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const std::size_t first = BodyContacts::kRows * i, contact = BodyContacts::kLanes * i;
    const Four hardness = four_at(&hardness_[contact]);
    const ContactLanes anchor = lanes_at(&anchor_[first]), v = lanes_at(&u[first]);
    const auto asked = [&](const Four& from, const Four& by) {
      return select(none < hardness, from - by * hardness, none);
    };
    ContactLanes y = {asked(anchor.n, v.n), asked(anchor.t1, v.t1), asked(anchor.t2, v.t2)};
    y.n -= four_at(&slip_[contact]) * hardness;
    put(y, &asked_[first]);
    put(project_on_cones(four_at(&friction_[contact]), y), &gamma_[first]);
  }
  project_others(u);
}

void ConvexContacts::project_others(const std::vector<double>& u) {
  for (std::size_t k = 0; k < other_contacts_; ++k) {
    const std::size_t contact = first_other_contact() + k, first = first_other() + 3 * k;
    const double hardness = hardness_[contact];
    double* const y = &asked_[first];
    for (std::size_t i = 0; i < 3; ++i)
      y[i] = hardness > 0.0 ? anchor_[first + i] - u[first + i] * hardness : 0.0;
    y[0] -= slip_[contact] * hardness;
    project_on_cone(friction_[contact], y, length_of(y[1], y[2]), &gamma_[first]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = joint_place(j);
    const double hardness = hardness_[first_joint() + j];
    asked_[r] = hardness > 0.0 ? anchor_share_[j] * anchor_[r] - u[r] * hardness : 0.0;
    gamma_[r] = hardness > 0.0 ? clamped(asked_[r], problem_.bounds[j]) : 0.0;
  }
}

/// M V: of bodies by what is not 0.
void ConvexContacts::multiply_by_masses(const std::vector<double>& V, std::vector<double>& to) const {
  for (std::size_t i = 0; i < problem_.sizes.size(); ++i) {
    const std::size_t n = problem_.sizes[i];
    const double* const M = &problem_.masses[first_mass_[i]];
    const double* const v = &V[first_[i]];
    double* const t = &to[first_[i]];
    if (!problem_.bodies.empty() && problem_.bodies[i].mass > 0.0) {
      for (std::size_t r = 0; r < 3; ++r) {
        const double* const row = M + (r + 3) * kBodyRates + 3;
        t[r] = problem_.bodies[i].mass * v[r];
        t[r + 3] = (row[0] * v[3] + row[1] * v[4]) + row[2] * v[5];
      }
      continue;
    }
    for (std::size_t r = 0; r < n; ++r) {
      double sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) sum += M[r * n + k] * v[k];
      t[r] = sum;
    }
  }
}

/// M V - J^T gamma.
void ConvexContacts::find_gradient() {
  multiply_by_masses(V_, gradient_);
  for (std::size_t i = 0; i < body_contacts_.size(); ++i)
    add_impulses(body_contacts_[i], lanes_at(&gamma_[BodyContacts::kRows * i]), -1.0, gradient_.data());
  for_other_rows([&](std::size_t r, std::size_t place) {
    if (gamma_[place] != 0.0) add(problem_.rows[r], problem_.J, -gamma_[place], gradient_);
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
      // J^T G J is added; contacts over units of six rates have a routine of fixed size.
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

/// J^T G J of the contacts between the same bodies from a block on. @return the next block that is another's
std::size_t ConvexContacts::add_pair(std::size_t first) {
  const BodyContacts& pair = body_contacts_[first];
  PairStiffness stiffness;
  std::size_t i = first;
  for (; i < body_contacts_.size(); ++i) {
    const BodyContacts& contacts = body_contacts_[i];
    if (contacts.count != pair.count || contacts.first[0] != pair.first[0] ||
        contacts.first[1] != pair.first[1])
      break;
    const SymmetricLanes G = symmetric_at(&stiffness_[kStiffnessLanes * i]);
    if (is_any(in_all(0.0) < G.of[0])) stiffness.add(contacts, G);
  }
  if (stiffness.is_empty()) return i;
  for (int side = 0; side < pair.count; ++side)
    stiffness.write_own(side, cholesky_.diagonal(pair.units[side]));
  if (pair.count < 2) return i;
  bool is_transposed = false;  // its rows are those of the unit that is eliminated later
  double* const block = cholesky_.block(pair.units[0], pair.units[1], is_transposed);
  stiffness.write_both(!is_transposed, block);
  return i;
}

/// G of every contact and joint at the impulses asked_, 0 where nothing presses. @return whether it is as it
/// was when the system was last factored.
bool ConvexContacts::find_stiffness() {
  stiffness_.swap(last_stiffness_);
  stiffness_.resize(first_other_stiffness() + 9 * other_contacts_ + problem_.bounds.size());
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const std::size_t contact = BodyContacts::kLanes * i;
    const SymmetricLanes G =
        slopes_of_projection(four_at(&friction_[contact]), lanes_at(&asked_[BodyContacts::kRows * i]),
                             four_at(&hardness_[contact]));
    put(G, &stiffness_[kStiffnessLanes * i]);
  }
  find_stiffness_of_others();
  return is_factored_ && stiffness_ == last_stiffness_;
}

void ConvexContacts::find_stiffness_of_others() {
  double* G = stiffness_.data() + first_other_stiffness();
  for (std::size_t i = 0; i < other_contacts_; ++i, G += 9) {
    const std::size_t contact = first_other_contact() + i;
    std::fill_n(G, 9, 0.0);
    if (hardness_[contact] > 0.0)
      slope_of_projection(friction_[contact], &asked_[first_other() + 3 * i], hardness_[contact], G);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j, ++G) {
    const std::size_t r = joint_place(j);
    const double hardness = hardness_[first_joint() + j];
    const bool is_within = asked_[r] >= problem_.bounds[j].lower && asked_[r] <= problem_.bounds[j].upper;
    *G = hardness > 0.0 && is_within ? hardness : 0.0;
  }
}

/// M + J^T G J.
void ConvexContacts::assemble() {
  cholesky_.clear();
  for (std::uint32_t i = 0; i < problem_.sizes.size(); ++i)
    std::copy_n(&problem_.masses[first_mass_[i]], problem_.sizes[i] * problem_.sizes[i],
                cholesky_.diagonal(i));
  for (std::size_t i = 0; i < body_contacts_.size();) i = add_pair(i);
  const double* G = stiffness_.data() + first_other_stiffness();
  for (std::size_t i = 0; i < other_contacts_; ++i, G += 9)
    if (G[0] > 0.0) add_rows(other_rows_[3 * i], 3, G);
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j, ++G)
    if (*G > 0.0) add_rows(3 * problem_.contacts + j, 1, G);
}

/// Of the potential along step_, and how that changes. From asked_.
double ConvexContacts::slope_at(double along, double& curvature) const {
  // Contacts between bodies, four at a time.
  Four slopes = in_all(0.0), curvatures = in_all(0.0);
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const std::size_t first = BodyContacts::kRows * i, contact = BodyContacts::kLanes * i;
    const Four hardness = four_at(&hardness_[contact]), by = in_all(along) * hardness;
    const ContactLanes du = lanes_at(&du_[first]), asked = lanes_at(&asked_[first]);
    const ContactLanes y = {asked.n - by * du.n, asked.t1 - by * du.t1, asked.t2 - by * du.t2};
    const ConeSlopes of = slopes_along(four_at(&friction_[contact]), y, du);
    slopes -= of.projection;
    curvatures += of.change * hardness;
  }
  double slope = sum_of(slopes);
  curvature = sum_of(curvatures);
  // Other contacts, then joint rows.
  for (std::size_t k = 0; k < other_contacts_; ++k) {
    const std::size_t contact = first_other_contact() + k, first = first_other() + 3 * k;
    const double hardness = hardness_[contact], by = along * hardness;
    const double* const du = &du_[first];
    const double* const asked = &asked_[first];
    const double y[3] = {asked[0] - by * du[0], asked[1] - by * du[1], asked[2] - by * du[2]};
    const ConeSlope of = slope_along(friction_[contact], y, du);
    slope -= of.projection;
    curvature += of.change * hardness;
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = joint_place(j);
    const double hardness = hardness_[first_joint() + j];
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
  // The quadratic part, of 1/2 V^T M V.
  multiply_by_masses(step_, trial_V_);
  const double a = sum_of_products(step_.data(), trial_V_.data(), step_.size());
  const double c = sum_of_products(V_.data(), trial_V_.data(), V_.size());
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
  Four most = in_all(0.0);
  for (const BodyContacts& contacts : body_contacts_) {
    const ContactLanes v = along_directions(contacts, relative_velocities(contacts, trial_V_.data()));
    most = worse_of(worse_of(worse_of(most, magnitude(v.n)), magnitude(v.t1)), magnitude(v.t2));
  }
  double worst = worst_of(most);
  for_other_rows([&](std::size_t r, std::size_t) {
    worst = worse_of(worst, std::abs(product(problem_.rows[r], problem_.Y, gradient_, 0.0)));
  });
  return worst;
}

/// V_, the velocities that follow from it and the impulses that make it. The impulses after a whole step are
/// gamma_ - G J dV, since M (V + dV) = J^T of them; so V_ is always theirs, solved or not.
void ConvexContacts::go_along(double along) {
  for (std::size_t k = 0; k < V_.size(); ++k) V_[k] += along * step_[k];
  // Contacts between bodies, four at a time.
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const std::size_t first = BodyContacts::kRows * i;
    const SymmetricLanes G = symmetric_at(&stiffness_[kStiffnessLanes * i]);
    const ContactLanes du = lanes_at(&du_[first]), gamma = lanes_at(&gamma_[first]);
    ContactLanes x = lanes_at(&impulses_[first]), u = lanes_at(&u_[first]);
    const Four part = in_all(along);
    x.n += part * ((gamma.n - ((G(0, 0) * du.n + G(0, 1) * du.t1) + G(0, 2) * du.t2)) - x.n);
    x.t1 += part * ((gamma.t1 - ((G(1, 0) * du.n + G(1, 1) * du.t1) + G(1, 2) * du.t2)) - x.t1);
    x.t2 += part * ((gamma.t2 - ((G(2, 0) * du.n + G(2, 1) * du.t1) + G(2, 2) * du.t2)) - x.t2);
    u = {u.n + part * du.n, u.t1 + part * du.t1, u.t2 + part * du.t2};
    put(x, &impulses_[first]);
    put(u, &u_[first]);
  }
  // Other contacts, then joint rows.
  const auto go = [&](std::size_t r, double by_stiffness) {
    impulses_[r] += along * ((gamma_[r] - by_stiffness) - impulses_[r]);
    u_[r] += along * du_[r];
  };
  const double* G = stiffness_.data() + first_other_stiffness();
  for (std::size_t k = 0; k < other_contacts_; ++k, G += 9) {
    const std::size_t first = first_other() + 3 * k;
    const double* const du = &du_[first];
    for (std::size_t i = 0; i < 3; ++i)
      go(first + i, (G[3 * i] * du[0] + G[3 * i + 1] * du[1]) + G[3 * i + 2] * du[2]);
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j, ++G) go(joint_place(j), *G * du_[joint_place(j)]);
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
    const double most = fastest(du_);
    if (!std::isfinite(most)) return Outcome::stuck;
    if (most <= tolerance * 1e-3 && most >= last) return Outcome::solved;  // rounding
    go_along(line_search());
    last = most;
  }
}

}  // namespace touchstone::physics
