#include "touchstone/contact_core/motion/slide.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/row_projection.hpp"

namespace touchstone {
namespace {

using Solver = RowProjection<kTwistSize>;
using Row6 = Solver::Row;

/// Longer turns are taken in several sub-steps [rad].
constexpr double kLongestTurn = 0.25;
constexpr int kLiftRounds = 4;
constexpr int kHalvings = 3;

/// J = L L^T, lower. A pivot that rounding leaves not positive (a needle's axis) becomes a share of J's
/// trace.
Matrix3 cholesky(const Matrix3& J) {
  const double least = 0x1p-60 * ((J(0, 0) + J(1, 1)) + J(2, 2));
  Matrix3 L = Matrix3::Zero();
  for (int j = 0; j < 3; ++j) {
    for (int i = j; i < 3; ++i) {
      double rest = J(i, j);
      for (int k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
      L(i, j) = i == j ? std::sqrt(std::max(rest, least)) : rest / L(j, j);
    }
  }
  return L;
}

using Row3 = std::array<double, 3>;

/// L^T x.
Row3 times_transposed(const Matrix3& L, const Vector3& x) {
  Row3 out{};
  for (int i = 0; i < 3; ++i)
    for (int k = i; k < 3; ++k) out[i] += L(k, i) * x[k];
  return out;
}
/// L^-T x.
Vector3 solve_transposed(const Matrix3& L, const double* x) {
  Vector3 out;
  for (int i = 2; i >= 0; --i) {
    double rest = x[i];
    for (int k = i + 1; k < 3; ++k) rest -= L(k, i) * out[k];
    out[i] = rest / L(i, i);
  }
  return out;
}
/// L^-1 x.
Row3 solve_lower(const Matrix3& L, const Vector3& x) {
  Row3 out{};
  for (int i = 0; i < 3; ++i) {
    double rest = x[i];
    for (int k = 0; k < i; ++k) rest -= L(i, k) * out[k];
    out[i] = rest / L(i, i);
  }
  return out;
}

/// Twists as (M^T v, L^T w) with K = M M^T, J = L L^T: there the metric is Euclid's.
class Scaling {
 public:
  explicit Scaling(const TwistMetric& metric)
      : L_(cholesky(metric.J)),
        M_(metric.is_even ? metric.K : cholesky(metric.K)),
        is_even_(metric.is_even) {}

  Row6 to_scaled(const Twist& u) const {
    const Row3 v = is_even_ ? Row3{u.v.x(), u.v.y(), u.v.z()} : times_transposed(M_, u.v);
    const Row3 w = times_transposed(L_, u.w);
    return {v[0], v[1], v[2], w[0], w[1], w[2]};
  }
  Twist from_scaled(const Row6& x) const {
    Twist u;
    u.v = is_even_ ? Vector3(x[0], x[1], x[2]) : solve_transposed(M_, &x[0]);
    u.w = solve_transposed(L_, &x[3]);
    return u;
  }
  /// Of a moment: M^-1 n, L^-1 m.
  Row6 row(const Vector3& n, const Vector3& moment) const {
    const Row3 v = is_even_ ? Row3{n.x(), n.y(), n.z()} : solve_lower(M_, n);
    const Row3 w = solve_lower(L_, moment);
    return {v[0], v[1], v[2], w[0], w[1], w[2]};
  }

 private:
  Matrix3 L_, M_;
  bool is_even_;
};

using Lifts = std::array<double, kMostSlideRows>;

/// With n' = (w x e) x f: the distance h = n . d from f to e has h'' = n'' . d + 2 n' . d' + n . d'', where
/// n' . d' is known at first and changes by no more than |n''| |d'| + |n'| |d''|.
double bend_of_edges(const SlideRow& row, const Twist& twist) {
  const double turn = norm(twist.w), steepness = norm(row.e) * norm(row.f);
  const Vector3 rate = twist.v + cross(twist.w, row.r), n_rate = cross(cross(twist.w, row.e), row.f);
  const double acceleration = turn * norm(cross(twist.w, row.r)), speed = norm(rate) + acceleration;
  const double turning = steepness * turn * turn;
  return 3.0 * turning * speed + (1.0 + 2.0 * steepness * turn) * acceleration - 2.0 * dot(n_rate, rate);
}

/// How far the rows have to be raised for a twist's path to stay above; false where `lift` already does.
bool raise(std::span<const SlideRow> rows, const Twist& twist, Lifts& lift) {
  bool raised = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double needed = 0.5 * bend_of(rows[i], twist) - rows[i].room;
    if (needed <= lift[i]) continue;
    lift[i] = needed;
    raised = true;
  }
  return raised;
}

/// By how much the square of the distance to the goal shrinks.
double gain_of(const Twist& goal, const TwistMetric& metric_W, const Twist& u) {
  return 2.0 * inner_product(metric_W, u, goal) - inner_product(metric_W, u, u);
}

/// False where the rows cannot be raised so far.
/// @param straight by how much the distance to the goal would shrink if nothing were raised, as gain_of().
bool project_lifted(const Twist& goal, const TwistMetric& metric_W, std::span<const SlideRow> rows,
                    bool translation_only, SlidePlan& plan, double& straight) {
  Lifts lift{};
  const std::span<const double> lifts = std::span(lift).first(rows.size());
  for (int round = 0; round < kLiftRounds; ++round) {
    plan.work += rows.size();
    if (!project(goal, metric_W, rows, lifts, translation_only, plan.twist, plan.active)) return false;
    if (round == 0) straight = gain_of(goal, metric_W, plan.twist);
    if (!raise(rows, plan.twist, lift)) break;
  }
  // Half the square of the distance grows by the force for each unit that a row is raised.
  plan.left_over = 0.0;
  for (int i = 0; i < plan.active.count; ++i) {
    const auto row = static_cast<std::size_t>(plan.active.row[i]);
    plan.left_over += 2.0 * plan.active.force[i] * (lift[row] + rows[row].room);
  }
  return true;
}

/// Shortened by no more than this share a plan is whole: what that costs is of second order.
constexpr double kWhole = 1.0 - 0x1p-12;

/// A plan that gains less than this share of what it would gain if nothing were raised for bends, which is
/// the most that any gains, is made for half as far as well.
constexpr double kEnough = 0.25;

/// As far as the distance to the goal shrinks: the share of u; 0: nothing is to be gained.
double share_that_gains(const Twist& goal, const TwistMetric& metric_W, const Twist& u) {
  const double forward = inner_product(metric_W, u, goal), square = inner_product(metric_W, u, u);
  if (!(forward > 0.0) || !(square > 0.0)) return 0.0;
  return forward < square ? forward / square : 1.0;
}

}  // namespace

bool operator<(const SlideRow& a, const SlideRow& b) {
  if (a.slack != b.slack) return a.slack < b.slack;
  for (int i = 0; i < 3; ++i)
    if (a.n[i] != b.n[i]) return a.n[i] < b.n[i];
  for (int i = 0; i < 3; ++i)
    if (a.r[i] != b.r[i]) return a.r[i] < b.r[i];
  if (a.turns != b.turns) return a.turns < b.turns;
  if (a.room != b.room) return a.room < b.room;
  for (int i = 0; i < 3; ++i)
    if (a.e[i] != b.e[i]) return a.e[i] < b.e[i];
  for (int i = 0; i < 3; ++i)
    if (a.f[i] != b.f[i]) return a.f[i] < b.f[i];
  return a.link != b.link ? a.link < b.link : a.other_link < b.other_link;
}

double inner_product(const TwistMetric& metric, const Twist& a, const Twist& b) {
  if (metric.is_even) return inner_product(metric.J, a, b);
  return dot(a.v, rotate(metric.K, b.v)) + dot(a.w, rotate(metric.J, b.w));
}

double bend_of(const SlideRow& row, const Twist& twist) {
  if (row.e != Vector3::Zero()) return bend_of_edges(row, twist);
  const double tilt = norm(cross(twist.w, row.n));
  const double around = norm(cross(twist.w, row.r));
  if (!row.turns) return tilt * around;
  return tilt * (around + norm(cross(twist.w, twist.v))) + 2.0 * tilt * norm(twist.v);
}

bool project(const Twist& goal, const TwistMetric& metric_W, std::span<const SlideRow> rows,
             std::span<const double> lift, bool translation_only, Twist& out, ActiveRows& active) {
  const Scaling scaling(metric_W);
  const Twist wanted{goal.v, translation_only ? Vector3(Vector3::Zero()) : goal.w};
  Solver::Rows scaled;
  std::array<double, kMostSlideRows> length_of;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vector3 moment = translation_only ? Vector3(Vector3::Zero()) : cross(rows[i].r, rows[i].n);
    Row6 g = scaling.row(rows[i].n, moment);
    const double length = std::sqrt(Solver::row_product(g, g));
    for (double& component : g) component /= length;
    length_of[i] = length;
    scaled.g[scaled.count] = g;
    scaled.slack[scaled.count++] = (rows[i].slack - lift[i]) / length;
  }
  Solver::State state;
  state.x = scaling.to_scaled(wanted);
  const bool found = Solver::find(scaled, state);
  active = {state.count, state.active, {}};
  for (int i = 0; i < state.count; ++i) active.force[i] = state.multiplier[i] / length_of[state.active[i]];
  out = found ? scaling.from_scaled(state.x) : Twist{};
  return found;
}

SlidePlan plan_slide(const Twist& goal, const TwistMetric& metric_W, std::span<const SlideRow> rows,
                     bool translation_only) {
  // A turn that is too long is planned in part.
  const double turn = translation_only ? 0.0 : norm(goal.w);
  const Twist wanted = turn > kLongestTurn ? (kLongestTurn / turn) * goal : goal;
  SlidePlan plan, best;
  // The bends of a motion half as long are a quarter: where those of a long one cannot be cleared, or leave
  // little of it, half of it may gain more.
  double part = 1.0, most_gain = 0.0, straight = kInfinity;
  for (int i = 0; i <= kHalvings; ++i, part *= 0.5) {
    double straight_part = 0.0;
    if (!project_lifted(part * wanted, metric_W, rows, translation_only, plan, straight_part)) continue;
    if (i == 0) straight = straight_part;
    const double share = share_that_gains(part * wanted, metric_W, plan.twist);
    if (!(share > 0.0)) continue;
    plan.twist = share * plan.twist;
    plan.is_whole = i == 0 && turn <= kLongestTurn && share >= kWhole;
    const double gain = gain_of(wanted, metric_W, plan.twist);
    if ((i == 0 && share >= kWhole) || gain >= kEnough * straight) return plan;
    if (!(gain > most_gain)) break;
    most_gain = gain, best = plan;
  }
  if (most_gain > 0.0) {
    best.work = plan.work;
    return best;
  }
  plan.is_whole = false;
  // No part gained: the plan only keeps contact to first order, as far as that goes.
  std::array<SlideRow, kMostSlideRows> kept;
  std::copy(rows.begin(), rows.end(), kept.begin());
  for (SlideRow& row : kept) row.slack = std::max(row.slack, 0.0);
  const Lifts none{};
  const std::span<const SlideRow> kept_rows = std::span(kept).first(rows.size());
  plan.work += rows.size();
  if (!project(wanted, metric_W, kept_rows, std::span(none).first(rows.size()), translation_only, plan.twist,
               plan.active)) {
    SlidePlan stays;
    stays.work = plan.work;
    return stays;
  }
  plan.twist = share_that_gains(wanted, metric_W, plan.twist) * plan.twist;
  return plan;
}

}  // namespace touchstone
