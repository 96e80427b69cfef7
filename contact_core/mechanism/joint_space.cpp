#include "touchstone/contact_core/mechanism/joint_space.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = Mechanism::kNone;
constexpr int kLiftRounds = 4;
constexpr int kHalvings = 3;
/// Longer changes of a value are taken in several sub-steps [rad] or [m].
constexpr double kLongestChange = 0.25;

using Lifts = std::array<double, kMostRows>;

/// Changes of joint values y = L^T dq, of which the metric is Euclid's; L may be diagonal.
template <int N>
class Scaling {
 public:
  using Row = std::array<double, N>;

  explicit Scaling(const JointMetric& metric) : size_(metric.weights.size()), root_(metric.root) {
    for (std::size_t k = 0; k < size_; ++k)
      scale_[k] = root_ != nullptr ? (*root_)[k][k] : std::sqrt(metric.weights[k]);
  }
  Row to_scaled(const JointVector& dq) const {
    Row y{};
    for (std::size_t k = 0; k < size_; ++k) {
      y[k] = scale_[k] * dq[k];
      for (std::size_t i = k + 1; root_ != nullptr && i < size_; ++i) y[k] += (*root_)[i][k] * dq[i];
    }
    return y;
  }
  JointVector from_scaled(const Row& y) const {
    JointVector dq{};
    for (std::size_t k = size_; k-- > 0;) {
      double rest = y[k];
      for (std::size_t i = k + 1; root_ != nullptr && i < size_; ++i) rest -= (*root_)[i][k] * dq[i];
      dq[k] = rest / scale_[k];
    }
    return dq;
  }
  /// g . dq = row(g) . y.
  Row row(const JointVector& g) const {
    Row out{};
    for (std::size_t k = 0; k < size_; ++k) {
      double rest = g[k];
      for (std::size_t j = 0; root_ != nullptr && j < k; ++j) rest -= (*root_)[k][j] * out[j];
      out[k] = rest / scale_[k];
    }
    return out;
  }

 private:
  std::size_t size_;
  const JointMatrix* root_;
  Row scale_{};
};

/// Rows in scaled coordinates and of unit length, for any number of projections. Those that no joint moves
/// are left out.
template <int N>
class ScaledRows {
 public:
  ScaledRows(const JointMetric& metric, std::span<const JointRow> rows) : scaling_(metric), rows_(rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      typename Solver::Row g = scaling_.row(rows[i].g);
      const double length = std::sqrt(Solver::row_product(g, g));
      if (!(length > 0.0)) continue;  // no joint moves it
      for (double& component : g) component /= length;
      row_of_[scaled_.count] = static_cast<int>(i), length_of_[scaled_.count] = length;
      scaled_.g[scaled_.count++] = g;
    }
  }

  /// @param slack one a row, by how far it may come nearer [m].
  bool project(const JointVector& goal, const Lifts& slack, const Lifts& lift, JointSlidePlan& plan) {
    for (int i = 0; i < scaled_.count; ++i) {
      scaled_.slack[i] = (slack[row_of_[i]] - lift[row_of_[i]]) / length_of_[i];
      scaled_.is_left_out[i] = false;
    }
    // The goal is projected in scaled coordinates.
    typename Solver::State state;
    state.x = scaling_.to_scaled(goal);
    const bool found = Solver::find(scaled_, state);
    // The plan names the active rows, with forces in the caller's units.
    const std::uint64_t before = plan.work;
    plan = {};
    plan.work = before + kWidth * static_cast<std::uint64_t>(scaled_.count + state.steps);
    plan.active_count = state.count;
    for (int i = 0; i < state.count; ++i) {
      const int active = state.active[i], row = row_of_[active];
      plan.active[i] = row;
      plan.force[i] = state.multiplier[i] / length_of_[active];
      // Half the square of the distance grows by the multiplier for each unit that a row is raised.
      plan.left_over += 2.0 * state.multiplier[i] * ((lift[row] + rows_[row].room) / length_of_[active]);
    }
    if (found) plan.dq = scaling_.from_scaled(state.x);
    return found;
  }

 private:
  using Solver = RowProjection<N>;
  static constexpr std::uint64_t kWidth = N / 8;  ///< in rows of eight joint values

  Scaling<N> scaling_;
  std::span<const JointRow> rows_;
  typename Solver::Rows scaled_;
  std::array<int, kMostRows> row_of_;
  std::array<double, kMostRows> length_of_;
};

/// How far a row is from where it binds.
double row_left(const JointRow& row, const JointVector& dq, std::size_t size) {
  double sum = row.slack;
  for (std::size_t k = 0; k < size; ++k) sum += row.g[k] * dq[k];
  return sum;
}

Lifts slacks_of(std::span<const JointRow> rows) {
  Lifts out;
  for (std::size_t i = 0; i < rows.size(); ++i) out[i] = rows[i].slack;
  return out;
}

/// By how much the square of the distance to the goal shrinks.
double gain_of(const JointVector& goal, const JointMetric& metric, const JointVector& dq) {
  return 2.0 * joint_product(dq, goal, metric) - joint_product(dq, dq, metric);
}

/// @param straight by how much the distance to the goal would shrink if nothing were raised for bends, as
/// gain_of().
template <int N>
bool project_lifted(const JointVector& goal, const JointMetric& metric, std::span<const JointRow> rows,
                    ScaledRows<N>& scaled, JointBends& bends, JointSlidePlan& plan, double& straight) {
  Lifts lift{};
  const Lifts slack = slacks_of(rows);
  for (int round = 0; round < kLiftRounds; ++round) {
    if (!scaled.project(goal, slack, lift, plan)) return false;
    if (round == 0) straight = gain_of(goal, metric, plan.dq);
    bends.lay(plan.dq);
    bool raised = false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      // A row that would hold when raised changes nothing.
      const double left = row_left(rows[i], plan.dq, metric.weights.size());
      if (0.5 * bends.most(i) - rows[i].room <= std::max(lift[i], left)) continue;
      const double needed = 0.5 * bends.bend(i) - rows[i].room;
      if (needed <= std::max(lift[i], left)) continue;
      lift[i] = needed;
      raised = true;
    }
    if (!raised) break;
  }
  return true;
}

void scale(JointVector& v, double factor) {
  for (double& component : v) component *= factor;
}

/// Shortened by no more than this share a plan is whole: what that costs is of second order.
constexpr double kWhole = 1.0 - 0x1p-12;

/// No plan gains more than one without bends: where one gains this share of that, none is made for half the
/// way.
constexpr double kEnough = 1.0 - 0x1p-4;

/// As far as the distance to the goal shrinks. @returns the share that is left; 0: nothing is to be gained.
double shorten(const JointVector& goal, const JointMetric& metric, JointVector& dq) {
  const double forward = joint_product(dq, goal, metric), square = joint_product(dq, dq, metric);
  const bool gains = forward > 0.0 && square > 0.0;
  const double share = !gains ? 0.0 : forward < square ? forward / square : 1.0;
  scale(dq, share);
  return share;
}

}  // namespace

JointFrame::JointFrame(const Mechanism& mechanism)
    : mechanism_(&mechanism),
      axes_(mechanism.value_count()),
      moves_(mechanism.links().size() * mechanism.value_count(), 0),
      reaches_(moves_.size(), 0.0) {
  for (std::uint32_t link = 0; link < mechanism.links().size(); ++link)
    for (const std::uint32_t j : mechanism.chain(link))
      if (mechanism.joints()[j].value != kNone) moves_[link * axes_.size() + mechanism.joints()[j].value] = 1;
}

void JointFrame::set(std::span<const Pose> X_WL) noexcept {
  for (const Mechanism::Joint& joint : mechanism_->joints()) {
    if (joint.value == kNone) continue;
    const Pose& X_WP = X_WL[joint.inner];
    axes_[joint.value] = {joint.kind == JointKind::revolute, rotate(X_WP.R, joint.axis_P),
                          transform(X_WP, joint.X_PJ.p)};
  }
}

void JointFrame::set_reaches(double shift_limit) noexcept {
  for (const std::uint32_t j : mechanism_->outwards()) {
    const Mechanism::Joint& joint = mechanism_->joints()[j];
    const double beyond = norm(joint.X_JC.p) + (joint.kind == JointKind::prismatic ? shift_limit : 0.0);
    for (std::uint32_t value = 0; value < axes_.size(); ++value)
      if (moves_[joint.inner * axes_.size() + value])
        reaches_[joint.outer * axes_.size() + value] =
            reaches_[joint.inner * axes_.size() + value] + norm(joint.X_PJ.p) + beyond;
    if (joint.value != kNone) reaches_[joint.outer * axes_.size() + joint.value] = beyond;
  }
}

double JointFrame::reach(std::uint32_t link, std::uint32_t other, double radius,
                         std::span<const double> weights) const {
  double sum = 0.0;
  for (std::uint32_t value = 0; value < axes_.size(); ++value) {
    if (sign(value, link, other) <= 0) continue;
    const double r = furthest(value, link, radius);
    sum += r * r / weights[value];
  }
  return std::sqrt(sum);
}

Twist JointFrame::twist(std::uint32_t value, const Vector3& c_W) const {
  const Axis& axis = axes_[value];
  if (!axis.turns) return {axis.direction_W, Vector3::Zero()};
  return {cross(axis.direction_W, c_W - axis.origin_W), axis.direction_W};
}

Twist JointFrame::twist(const JointVector& dq, std::uint32_t link, std::uint32_t other,
                        const Vector3& c_W) const {
  Twist sum;
  for (std::uint32_t value = 0; value < axes_.size(); ++value) {
    const int turn = sign(value, link, other);
    if (turn == 0 || dq[value] == 0.0) continue;
    const Twist part = (turn * dq[value]) * twist(value, c_W);
    sum.v += part.v;
    sum.w += part.w;
  }
  return sum;
}

void find_root(const JointMatrix& M, std::span<const double> weights, JointMatrix& L) noexcept {
  for (std::size_t i = 0; i < weights.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double rest = M[i][j];
      for (std::size_t k = 0; k < j; ++k) rest -= L[i][k] * L[j][k];
      // M without some of its values is no less stiff than their weights.
      L[i][j] = i == j ? std::sqrt(std::max(rest, weights[i])) : rest / L[j][j];
    }
  }
}

double joint_product(const JointVector& a, const JointVector& b, const JointMetric& metric) {
  double sum = 0.0;
  const std::size_t size = metric.weights.size();
  if (metric.root != nullptr) {
    const Scaling<kMostSlideJoints> scaling(metric);
    const auto x = scaling.to_scaled(a), y = scaling.to_scaled(b);
    for (std::size_t k = 0; k < size; ++k) sum += x[k] * y[k];
    return sum;
  }
  for (std::size_t k = 0; k < size; ++k) sum += metric.weights[k] * (a[k] * b[k]);
  return sum;
}

namespace {

/// Calls body(width), a constant, of a room that so many joint values fit in: what is not used costs time
/// alone.
template <class Body>
auto in_width(std::size_t values, Body body) {
  if (values <= 8) return body(std::integral_constant<int, 8>{});
  if (values <= 16) return body(std::integral_constant<int, 16>{});
  return body(std::integral_constant<int, kMostSlideJoints>{});
}

template <int N>
JointSlidePlan plan_scaled(const JointVector& goal, const JointMetric& metric, std::span<const JointRow> rows,
                           JointBends& bends) {
  double longest = 0.0;
  for (const double change : goal) longest = std::max(longest, std::abs(change));
  JointVector wanted = goal;
  if (longest > kLongestChange) scale(wanted, kLongestChange / longest);
  JointSlidePlan plan, best;
  ScaledRows<N> scaled(metric, rows);
  // Where a plan gains less than it would without bends, half of it may gain more: its bends are a quarter.
  const bool is_long = longest > kLongestChange;
  double most_gain = 0.0, straight = kInfinity;
  for (int i = 0; i <= kHalvings; ++i, scale(wanted, 0.5)) {
    double straight_part = kInfinity;
    const bool found = project_lifted(wanted, metric, rows, scaled, bends, plan, straight_part);
    // Below 0 where rows ask for room first: that tells nothing of what bends keep from the plan.
    if (i == 0 && !is_long && straight_part > 0.0) straight = straight_part;
    if (!found) continue;
    const double share = shorten(goal, metric, plan.dq);
    if (!(share > 0.0)) continue;
    const double gain = gain_of(goal, metric, plan.dq);
    plan.shortfall = straight - gain;
    plan.is_for_all = i == 0 && !is_long;
    plan.is_whole = plan.is_for_all && share >= kWhole;
    if (plan.is_whole || gain >= kEnough * straight) return plan;
    if (!(gain > most_gain)) break;
    most_gain = gain, best = plan;
  }
  if (most_gain > 0.0) {
    best.work = plan.work;
    return best;
  }
  // Nothing but to keep contact to first order, as far as that goes.
  Lifts kept = slacks_of(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) kept[i] = std::max(kept[i], 0.0);
  if (!scaled.project(wanted, kept, Lifts{}, plan) || !(shorten(goal, metric, plan.dq) > 0.0))
    plan.dq.fill(0.0);
  return plan;
}

}  // namespace

bool project_joints(const JointVector& goal, const JointMetric& metric, std::span<const JointRow> rows,
                    JointSlidePlan& plan) {
  const Lifts slack = slacks_of(rows);
  return in_width(metric.weights.size(), [&](auto width) {
    return ScaledRows<width()>(metric, rows).project(goal, slack, Lifts{}, plan);
  });
}

JointSlidePlan plan_joint_slide(const JointVector& goal, const JointMetric& metric,
                                std::span<const JointRow> rows, JointBends& bends) {
  return in_width(metric.weights.size(),
                  [&](auto width) { return plan_scaled<width()>(goal, metric, rows, bends); });
}

}  // namespace touchstone
