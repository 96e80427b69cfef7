#include "touchstone/examples/training_run/setting/hand.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::training {
namespace {

constexpr int kResolveSteps = 12;
/// A rate this much beyond its limit is the limit, rounded.
constexpr double kRounding = 0x1p-40;

/// From one pose to the other: of the origin, and the shorter turn.
Twist difference(const Pose& from, const Pose& to) {
  return {to.p - from.p, RigidPath::between(from, to).at(0, 0.0).angular_velocity_W};
}

double length(const Twist& twist) { return norm(twist.v) + norm(twist.w); }

}  // namespace

RigidPath flown(const Pose& X_WO, const HandRates& rates, double duration) {
  const bool own = rates.mode == HandRates::Mode::hand;
  const Vector3 v = own ? rotate(X_WO.R, rates.velocity) : rates.velocity;
  const Vector3 w = own ? rotate(X_WO.R, rates.turn) : rates.turn;
  return RigidPath::by(X_WO, duration * v, duration * w);
}

ArmHand::ArmHand(const Arm& arm, std::uint32_t link)
    : arm_(&arm),
      link_(link),
      control_(*arm.mechanism, link, {}, arm.held_values),
      commanded_(arm.joints),
      best_(arm.joints.size()),
      rates_(arm.joints.size()),
      X_WL_(arm.mechanism->links().size()) {
  target_ = pose_at(commanded_);
  figures_.is_arm = true;
}

void ArmHand::start_from(std::span<const double> q) noexcept {
  target_ = pose_at(q);
  std::copy(q.begin(), q.end(), commanded_.begin());
}

Pose ArmHand::pose_at(std::span<const double> q) noexcept {
  arm_->mechanism->link_poses(arm_->X_WB, q, X_WL_);
  return X_WL_[link_];
}

void ArmHand::aim_from(std::span<const double> q, const HandRates& rates) noexcept {
  const Pose now = pose_at(q);
  const Pose before = target_;
  target_ = now;
  if (!arm_->holds) return;
  if (rates.turn == Vector3::Zero()) target_.R = before.R;
  const Matrix3 axes = rates.mode == HandRates::Mode::hand ? target_.R : Matrix3::Identity();
  for (int i = 0; i < 3; ++i)
    if (rates.velocity[i] == 0.0) target_.p += dot(axes.col(i), before.p - now.p) * axes.col(i);
}

bool ArmHand::limit(std::span<const double> q, double duration, std::span<double> next) const noexcept {
  double share = 1.0;
  for (const Mechanism::Joint& joint : arm_->mechanism->joints()) {
    if (joint.value == Mechanism::kNone) continue;
    const double from = q[joint.value], step = next[joint.value] - from;
    if (std::abs(step) > duration * joint.rate * (1.0 + kRounding))
      share = std::min(share, duration * joint.rate / std::abs(step));
    if (from + step > joint.upper) share = std::min(share, (joint.upper - from) / step);
    if (from + step < joint.lower) share = std::min(share, (joint.lower - from) / step);
  }
  if (share == 1.0) return false;
  for (std::size_t i = 0; i < q.size(); ++i) next[i] = q[i] + share * (next[i] - q[i]);
  return true;
}

void ArmHand::resolve(std::span<const double> q, const HandRates& rates, double duration,
                      std::span<double> next) noexcept {
  std::copy(q.begin(), q.end(), next.begin());
  double left = kInfinity;
  bool limited = false, damped = false;
  for (int i = 0; i < kResolveSteps && !limited; ++i) {
    const Pose now = pose_at(next);
    const Twist missing = difference(now, target_);
    if (!(length(missing) < left)) break;
    left = length(missing);
    std::copy(next.begin(), next.end(), best_.begin());
    const ResolvedRate::Outcome outcome = control_.solve(X_WL_, now.p, (1.0 / duration) * missing, rates_);
    limited = outcome.scale < 1.0;
    damped = damped || outcome.lambda > 0.0;
    for (std::size_t k = 0; k < q.size(); ++k) next[k] += duration * rates_[k];
  }
  if (!limited) std::copy(best_.begin(), best_.end(), next.begin());
  limited = limit(q, duration, next) || limited;
  figures_.limited_frames += limited;
  figures_.damped_frames += damped;
  if (limited)
    aim_from(next, rates);
  else
    figures_.largest_residual = std::max(figures_.largest_residual, left);
}

void ArmHand::command(std::span<const double> q, const HandRates& rates, double duration,
                      std::span<double> next) noexcept {
  // After a stop from where the arm is; otherwise from where the hand asked it to be, so that nothing adds
  // up.
  if (!std::equal(q.begin(), q.end(), commanded_.begin())) aim_from(q, rates);
  target_ = flown(target_, rates, duration).to();
  resolve(q, rates, duration, next);
  std::copy(next.begin(), next.end(), commanded_.begin());
}

}  // namespace touchstone::training
