#include "touchstone/physics/solver/convex_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {
namespace {

// R beside a contact's own W: soft at first, since that takes fewest steps, then harder from round to round,
// so that few of them take it out. Far above rounding, as impulses are differences of velocities over R.
// A start that leaves less than kHolds of the speeds holds already: the less it leaves, the less soft the
// first round is.
constexpr double kFirstSoftness = 1e-2, kHolds = 1e-5, kHarder = 0.03, kSoftness = 1e-5;
constexpr double kHarderBits = 5.0;  // -log2 of kHarder
// A round need not be solved better than to this share of the least that was left before it.
constexpr double kInexact = 0.01;
constexpr int kMostRounds = 20, kMostSteps = 40;
// Impulses prove a contradiction where what is commanded could only be met by so many times its speed: a
// wedge of one in fifty is pressed out, a narrower one is held. Where that was proven lately, a few times do.
constexpr double kNoWayOut = 50.0, kNoWayOutStill = 3.0;
// A start from the last step may give this share of the energy that it moves: a tenth too much of what
// rests.
constexpr double kStale = -0.4;
// A round that leaves more than this share of the residual of the one before brings nothing.
constexpr double kStuck = 0.7;
// Work of a step beside factoring, in operations: of a contact whose blocks are added, of a row.
constexpr double kAssembly = 450.0, kRowWork = 60.0;
// Slopes along a step below this share of the first count as 0.
constexpr double kFlat = 1e-3;
constexpr int kMostSearches = 20;

enum class Where : std::uint8_t { in, below, beside };  // the cone, its polar, neither

/// The projection on the cone. @param t length of y's tangents.
Where project_on_cone(double friction, const double* y, double t, double* p) {
  if (t <= friction * y[0]) {
    std::copy(y, y + 3, p);
    return Where::in;
  }
  if (friction * t <= -y[0]) {
    p[0] = p[1] = p[2] = 0.0;
    return Where::below;
  }
  p[0] = (y[0] + friction * t) / (1.0 + friction * friction);
  p[1] = friction * p[0] * (y[1] / t);
  p[2] = friction * p[0] * (y[2] / t);
  return Where::beside;
}

/// Its derivative times `factor`: symmetric, 3 x 3, row by row.
void slope_of_projection(double friction, const double* y, double factor, double* G) {
  const double t = length_of(y[1], y[2]);
  double p[3];
  std::fill(G, G + 9, 0.0);
  switch (project_on_cone(friction, y, t, p)) {
    case Where::below:
      return;
    case Where::in:
      G[0] = G[4] = G[8] = factor;
      return;
    case Where::beside:
      break;
  }
  const double share = factor / (1.0 + friction * friction), e1 = y[1] / t, e2 = y[2] / t;
  const double across = factor * (friction * p[0] / t), along = friction * friction * share;
  G[0] = share;
  G[1] = G[3] = friction * share * e1;
  G[2] = G[6] = friction * share * e2;
  G[4] = along * e1 * e1 + across * e2 * e2;
  G[8] = along * e2 * e2 + across * e1 * e1;
  G[5] = G[7] = (along - across) * e1 * e2;
}

/// How much the projection changes along d.
void change_of_projection(double friction, const double* y, const double* d, double* p, double* change) {
  const double t = length_of(y[1], y[2]);
  switch (project_on_cone(friction, y, t, p)) {
    case Where::below:
      change[0] = change[1] = change[2] = 0.0;
      return;
    case Where::in:
      std::copy(d, d + 3, change);
      return;
    case Where::beside:
      break;
  }
  const double e1 = y[1] / t, e2 = y[2] / t, out = e1 * d[1] + e2 * d[2], across = friction * p[0] / t;
  change[0] = (d[0] + friction * out) / (1.0 + friction * friction);
  change[1] = friction * change[0] * e1 + across * (d[1] - out * e1);
  change[2] = friction * change[0] * e2 + across * (d[2] - out * e2);
}

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

void ConvexContacts::reserve(std::size_t units, std::size_t rows, std::size_t widest) {
  cholesky_.reserve(units, rows, widest);
  pairs_.reserve(rows);
  for (auto* vector : {&first_, &first_mass_}) vector->reserve(units + 1);
  for (auto* vector :
       {&scale_, &hardness_, &slip_, &anchor_, &gamma_, &impulses_, &u_, &du_, &best_, &anchor_share_})
    vector->reserve(rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->reserve(units * widest);
  reach_.reserve(units * widest);
  blocks_.reserve(6 * widest);
  for (auto* vector : {&stiffness_, &last_stiffness_}) vector->reserve(3 * rows);
}

/// w: the largest diagonal entry of W of each block; and what masses that differ ask for.
void ConvexContacts::find_scales() {
  double most = 0.0, least = kInfinity;  // of a side's inverse mass
  const auto own = [&](std::size_t row) {
    const SparseContacts::Row& r = problem_.rows[row];
    double sum = 0.0;
    for (int i = 0; i < r.count; ++i) {
      double part = 0.0;
      for (std::size_t k = 0; k < problem_.sizes[r.units[i]]; ++k)
        part += problem_.J[r.first[i] + k] * problem_.Y[r.first[i] + k];
      sum += part;
      most = std::max(most, part);
      if (part > 0.0) least = std::min(least, part);
    }
    return sum;
  };
  scale_.clear();
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    scale_.push_back(std::max({own(3 * c), own(3 * c + 1), own(3 * c + 2)}));
  for (std::size_t r = 3 * problem_.contacts; r < problem_.rows.size(); ++r) scale_.push_back(own(r));
  // A contact's own W is that of the lighter side, which may carry what is heaviest.
  const double spread = std::max(1.0, kHarder * most / least);
  hardest_ = kSoftness / spread;
  price_ = 1.0 / (1.0 + std::ilogb(spread) / kHarderBits);  // the same bits from every C library
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
  for (auto* vector : {&anchor_, &gamma_, &impulses_, &u_, &du_, &best_}) vector->resize(rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->resize(rates);
  blocks_.resize(6 * widest);
  slip_.resize(problem.contacts);
  std::copy(x.begin(), x.end(), anchor_.begin());
  is_factored_ = false;
  find_scales();
  find_pairs();
}

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

/// How far velocities by gamma_ are from those of V [m/s], at most: J M^-1 of the gradient.
double ConvexContacts::missed() const {
  double worst = 0.0;
  for (const SparseContacts::Row& row : problem_.rows)
    worst = worse_of(worst, std::abs(product(row, problem_.Y, gradient_, 0.0)));
  return worst;
}

/// V_, what it makes and what makes it. The impulses after a whole step are gamma_ - G J dV, since M (V + dV)
/// = J^T of them; so V_ is always theirs, solved or not.
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
    project(u_);
    find_gradient();
    const double miss = missed();
    if (miss <= tolerance) return Outcome::solved;
    if (!std::isfinite(miss)) return Outcome::stuck;
    if (i == most_steps || (i > 0 && budget.is_spent())) return Outcome::spent;
    if (!find_stiffness()) {
      assemble();
      is_factored_ = cholesky_.factor();
      if (!is_factored_) return Outcome::stuck;
      budget.spend(price_ * (cholesky_.work() + kAssembly * static_cast<double>(problem_.contacts)));
    }
    for (std::size_t k = 0; k < gradient_.size(); ++k) step_[k] = -gradient_[k];
    cholesky_.solve(step_, first_);
    find_velocities(step_, du_, false);
    budget.spend(price_ * kRowWork * static_cast<double>(problem_.rows.size()));
    ++report_.newton_steps;
    double most = 0.0;
    for (const double du : du_) most = worse_of(most, std::abs(du));
    if (!std::isfinite(most)) return Outcome::stuck;
    if (most <= tolerance * 1e-3 && most >= last) return Outcome::solved;  // rounding
    go_along(line_search());
    last = most;
  }
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
    const double compliance = problem_.compliance_of(j), w = scale_[problem_.contacts + j] + compliance;
    u_[r] += compliance * x[r];
    if (w > 0.0) worst = worse_of(worst, w * std::abs(x[r] - clamped(x[r] - u_[r] / w, problem_.bounds[j])));
  }
  return worst;
}

/// Of what there is without impulses.
double ConvexContacts::fastest() const {
  double speed = 0.0;
  for (const double b : problem_.b) speed = std::max(speed, std::abs(b));
  return speed;
}

/// Of the velocities u_.
void ConvexContacts::find_slips() {
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    slip_[c] = problem_.friction[c] * length_of(u_[3 * c + 1], u_[3 * c + 2]);
}

/// Else standing still is a way out.
bool ConvexContacts::presses_on_commands() const {
  for (std::size_t c = 0; c < problem_.commanded.size(); ++c)
    if (problem_.commanded[c] < 0.0 || (c >= problem_.contacts && problem_.commanded[c] > 0.0)) return true;
  return false;
}

/// Farkas' lemma: impulses in their cones with J^T x = 0 and x commanded < 0 say that no velocities V meet
/// the laws' J V + commanded. Of impulses that grow without end (as in Banjac, Goulart, Stellato, Boyd,
/// Infeasibility Detection in the Alternating Direction Method of Multipliers, 2019) J^T x is small beside x,
/// and V would have to be larger than -x commanded / |J^T x|. That asks nothing of masses: what is heavy on
/// what is light presses hard, and is moved by as much.
bool ConvexContacts::proves_contradiction(std::span<const double> x, double times) {
  if (!presses_on_commands()) return false;
  std::vector<double>& y = trial_V_;
  std::fill(y.begin(), y.end(), 0.0);
  reach_.assign(y.size(), 0.0);
  double pressed = 0.0, fastest_commanded = 0.0;
  for (std::size_t r = 0; r < x.size(); ++r) {
    const bool is_contact = r < 3 * problem_.contacts;
    const std::size_t block = is_contact ? r / 3 : r - 2 * problem_.contacts;
    if (!is_contact) {  // what has an end, or gives way, is no direction
      const std::size_t j = r - 3 * problem_.contacts;
      const double end = x[r] > 0.0 ? problem_.bounds[j].upper : problem_.bounds[j].lower;
      if (std::isfinite(end) || problem_.compliance_of(j) > 0.0) continue;
    }
    if (!is_contact || r % 3 == 0) {
      pressed -= x[r] * problem_.commanded[block];
      fastest_commanded = std::max(
          fastest_commanded, is_contact ? -problem_.commanded[block] : std::abs(problem_.commanded[block]));
    }
    const SparseContacts::Row& row = problem_.rows[r];
    if (x[r] != 0.0) add(row, problem_.J, x[r], y);
    for (int i = 0; i < row.count; ++i)
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) {
        double& reach = reach_[first_[row.units[i]] + k];
        reach = std::max(reach, std::abs(problem_.J[row.first[i] + k]));
      }
  }
  double moved = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (reach_[k] > 0.0) moved += std::abs(y[k]) / reach_[k];
  return pressed > times * fastest_commanded * moved;
}

/// Impulses x with u_ = W x + b give the energy x (u + b) / 2. Where that is more than `most_given` of what
/// they move, as unsolved ones may, the share of them that takes most is left: -x b / x W x.
/// @return whether x is another now.
bool ConvexContacts::take_energy(std::span<double> x, double most_given) {
  double by_b = 0.0, by_W = 0.0;
  for (std::size_t r = 0; r < x.size(); ++r) {
    by_b += x[r] * problem_.b[r];
    by_W += x[r] * (u_[r] - problem_.b[r]);
  }
  if (!(by_b + 0.5 * by_W > most_given * by_W)) return false;
  const double share = by_W > 0.0 && by_b < 0.0 ? -by_b / by_W : 0.0;
  for (double& impulse : x) impulse *= share;
  return true;
}

/// The residual of impulses that give no energy. @param x in: any.
double ConvexContacts::judge(std::span<double> x) {
  const double residual = residual_of(x);
  return take_energy(x, 0.0) ? residual_of(x) : residual;
}

/// The soft answer around 0, which is the anchor from then on. @param is_proven that the contacts contradict
/// each other, lately. @return whether they do so still, or no work is left for others: then it is the best.
bool ConvexContacts::soften(double tolerance, bool is_proven, WorkBudget& budget) {
  set_softness(kSoftAnswer);
  std::fill(anchor_.begin(), anchor_.end(), 0.0);
  const Outcome outcome = minimise(tolerance, budget, kMostSteps);
  if (outcome == Outcome::stuck) return false;
  anchor_ = outcome == Outcome::solved ? gamma_ : impulses_;
  // Where the work ends here it is the best there is: other answers may press without end.
  const bool is_last = outcome == Outcome::spent && budget.is_spent();
  // Impulses of an unsolved problem are in no cone, and prove nothing.
  const bool is_solved = outcome == Outcome::solved;
  report_.is_certain = is_solved && proves_contradiction(anchor_, kNoWayOut);
  report_.is_contradictory =
      report_.is_certain || (is_solved && is_proven && proves_contradiction(anchor_, kNoWayOutStill));
  if (!report_.is_contradictory && !is_last) return false;
  best_ = anchor_;
  report_.residual = judge(best_);
  return true;
}

ConvexReport ConvexContacts::solve_softly(const SparseContacts& problem, std::span<double> x,
                                          double tolerance, WorkBudget& budget, int most_steps) {
  load(problem, x);
  set_softness(kSoftAnswer);
  start();
  for (auto* vector : {&anchor_, &slip_}) std::fill(vector->begin(), vector->end(), 0.0);
  report_.converged = minimise(tolerance, budget, most_steps) == Outcome::solved;
  std::copy(impulses_.begin(), impulses_.end(), x.begin());
  return report_;
}

/// Starts from what held in a step of other velocities, scaled so that it takes most energy.
void ConvexContacts::start() {
  report_.residual = residual_of(anchor_);
  if (take_energy(anchor_, kStale)) report_.residual = residual_of(anchor_);
  best_ = impulses_ = anchor_;
  V_ = trial_V_;
}

ConvexReport ConvexContacts::solve(const SparseContacts& problem, std::span<double> x, double tolerance,
                                   WorkBudget& budget, Softness first) {
  load(problem, x);
  start();
  double last = report_.residual;
  const double left = last > 0.0 ? last / std::max(fastest(), last) : 0.0;
  const double first_softness = std::clamp(kFirstSoftness * (left / kHolds), kSoftness, kFirstSoftness);
  bool is_first = true;
  bool is_over = report_.residual <= tolerance;
  if (first != Softness::last && !is_over && presses_on_commands()) {
    find_slips();
    is_over = soften(tolerance, first == Softness::first, budget);
  }
  if (!is_over) {
    // Without contradiction what there is to start from serves better than the soft answer; with it, that
    // goes on to grow.
    if (first == Softness::first) std::copy(x.begin(), x.end(), anchor_.begin()), start();
    set_softness(first == Softness::maybe ? kHarder * kSoftAnswer : first_softness);
  }
  for (int round = 0; round < kMostRounds && !is_over; ++round) {
    find_slips();
    const Outcome outcome = minimise(std::max(0.1 * tolerance, kInexact * last), budget, kMostSteps);
    if (outcome == Outcome::stuck) break;
    if (outcome == Outcome::solved) impulses_ = gamma_;
    anchor_ = impulses_;
    const double residual = judge(anchor_);
    // The first round's is better than what there was to start from, whatever its residual, where that was
    // for other velocities.
    const bool is_new = is_first && first_softness == kFirstSoftness;
    if (is_new || residual < report_.residual) report_.residual = residual, best_ = anchor_;
    if (outcome == Outcome::spent || report_.residual <= tolerance) break;
    const bool is_stuck = !is_first && !(residual <= kStuck * last);
    if (proves_contradiction(anchor_, kNoWayOut)) {
      report_.is_certain = soften(tolerance, true, budget);
      break;
    }
    if (is_stuck && softness_ <= hardest_) break;
    is_first = false;
    set_softness(std::max(is_stuck ? hardest_ : std::min(kSoftness, softness_), kHarder * softness_));
    last = std::min(last, residual);
  }
  report_.converged = report_.residual <= tolerance;
  std::copy(best_.begin(), best_.end(), x.begin());
  return report_;
}

}  // namespace touchstone::physics
