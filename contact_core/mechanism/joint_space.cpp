#include "touchstone/contact_core/mechanism/joint_space.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = Mechanism::kNone;
constexpr int kLiftRounds = 4;
constexpr int kHalvings = 3;
/// Longer changes of a value are taken in several sub-steps [rad] or [m].
constexpr double kLongestChange = 0.25;

using Lifts = std::array<double, kMostRows>;

/// Scaled by the roots of the weights the metric is Euclid's.
template <int N>
bool project(const JointVector& goal, std::span<const double> weights, std::span<const JointRow> rows,
             const Lifts& lift, JointSlidePlan& plan) {
  using Solver = ClosestPoint<N>;
  typename Solver::Rows scaled;
  std::array<double, N> scale{};
  for (std::size_t k = 0; k < weights.size(); ++k) scale[k] = std::sqrt(weights[k]);
  std::array<int, kMostRows> row_of;
  std::array<double, kMostRows> length_of;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    typename Solver::Row g{};
    for (std::size_t k = 0; k < weights.size(); ++k) g[k] = rows[i].g[k] / scale[k];
    const double length = std::sqrt(Solver::row_product(g, g));
    if (!(length > 0.0)) continue;  // no joint moves it
    for (double& component : g) component /= length;
    row_of[scaled.count] = static_cast<int>(i), length_of[scaled.count] = length;
    scaled.g[scaled.count] = g;
    scaled.slack[scaled.count++] = (rows[i].slack - lift[i]) / length;
  }
  typename Solver::State state;
  for (std::size_t k = 0; k < weights.size(); ++k) state.x[k] = scale[k] * goal[k];
  const bool found = Solver::find(scaled, state);
  plan = {};
  plan.active_count = state.count;
  for (int i = 0; i < state.count; ++i) {
    const int row = row_of[state.active[i]];
    plan.active[i] = row;
    // Half the square of the distance grows by the multiplier for each unit that a row is raised.
    plan.left_over += 2.0 * state.multiplier[i] * ((lift[row] + rows[row].room) / length_of[state.active[i]]);
  }
  if (!found) return false;
  for (std::size_t k = 0; k < weights.size(); ++k) plan.dq[k] = state.x[k] / scale[k];
  return true;
}

bool project_any(const JointVector& goal, std::span<const double> weights, std::span<const JointRow> rows,
                 const Lifts& lift, JointSlidePlan& plan) {
  return weights.size() <= 8 ? project<8>(goal, weights, rows, lift, plan)
                             : project<kMostSlideJoints>(goal, weights, rows, lift, plan);
}

/// How far a row is from where it binds.
double row_left(const JointRow& row, const JointVector& dq, std::size_t size) {
  double sum = row.slack;
  for (std::size_t k = 0; k < size; ++k) sum += row.g[k] * dq[k];
  return sum;
}

bool project_lifted(const JointVector& goal, std::span<const double> weights, std::span<const JointRow> rows,
                    JointBends& bends, JointSlidePlan& plan) {
  Lifts lift{};
  for (int round = 0; round < kLiftRounds; ++round) {
    if (!project_any(goal, weights, rows, lift, plan)) return false;
    bends.lay(plan.dq);
    bool raised = false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      // A row that would hold when raised changes nothing.
      const double left = row_left(rows[i], plan.dq, weights.size());
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

/// As far as the distance to the goal shrinks. @returns the share that is left; 0: nothing is to be gained.
double shorten(const JointVector& goal, std::span<const double> weights, JointVector& dq) {
  const double forward = joint_product(dq, goal, weights), square = joint_product(dq, dq, weights);
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
    const int way = sign(value, link, other);
    if (way == 0 || dq[value] == 0.0) continue;
    const Twist part = (way * dq[value]) * twist(value, c_W);
    sum.v += part.v;
    sum.w += part.w;
  }
  return sum;
}

double joint_product(const JointVector& a, const JointVector& b, std::span<const double> weights) {
  double sum = 0.0;
  for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * (a[k] * b[k]);
  return sum;
}

JointSlidePlan plan_joint_slide(const JointVector& goal, std::span<const double> weights,
                                std::span<const JointRow> rows, JointBends& bends) {
  double longest = 0.0;
  for (const double change : goal) longest = std::max(longest, std::abs(change));
  JointVector wanted = goal;
  if (longest > kLongestChange) scale(wanted, kLongestChange / longest);
  JointSlidePlan plan;
  for (int i = 0; i <= kHalvings; ++i, scale(wanted, 0.5)) {
    if (!project_lifted(wanted, weights, rows, bends, plan)) continue;
    const double share = shorten(goal, weights, plan.dq);
    if (!(share > 0.0)) continue;
    plan.is_whole = i == 0 && longest <= kLongestChange && share >= kWhole;
    return plan;
  }
  // Nothing but to keep contact to first order, as far as that goes.
  std::array<JointRow, kMostRows> kept;
  std::copy(rows.begin(), rows.end(), kept.begin());
  for (std::size_t i = 0; i < rows.size(); ++i) kept[i].slack = std::max(kept[i].slack, 0.0);
  if (!project_any(wanted, weights, std::span(kept).first(rows.size()), Lifts{}, plan) ||
      !(shorten(goal, weights, plan.dq) > 0.0))
    plan.dq.fill(0.0);
  return plan;
}

}  // namespace touchstone
