#include "examples/training_run/hand.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/input_error.hpp"
#include "contact_core/mechanism/ssrms.hpp"

namespace touchstone::training {
namespace {

/// The arm is made to follow a stopped object by Newton steps; they end when they gain nothing.
constexpr int kFollowSteps = 12;

MechanismDescription description_of(const std::string& model) {
  if (model == "ssrms") return make_ssrms();
  throw InputError("arm '" + model + "' is not known; known: ssrms");
}

bool same(const Pose& X, const Pose& Y) { return X.p == Y.p && X.R == Y.R; }

/// From one pose to the other: of the origin, and the shorter turn.
Twist difference(const Pose& from, const Pose& to) {
  return {to.p - from.p, RigidPath::between(from, to).at(0, 0.0).angular_velocity_W};
}

double length(const Twist& twist) { return norm(twist.v) + norm(twist.w); }

RigidPath flown(const Pose& X_WO, const HandRates& rates, double duration) {
  const bool own = rates.mode == HandRates::Mode::hand;
  const Vector3 v = own ? rotate(X_WO.R, rates.velocity) : rates.velocity;
  const Vector3 w = own ? rotate(X_WO.R, rates.turn) : rates.turn;
  return RigidPath::by(X_WO, duration * v, duration * w);
}

}  // namespace

RigidPath FreeHand::command(const Pose& X_WO, const HandRates& rates, double duration) noexcept {
  return flown(X_WO, rates, duration);
}

ArmHand::ArmHand(const ArmScript& script, const Pose& X_WO)
    : arm_(description_of(script.model)),
      control_(arm_, arm_.find_link(script.link)),
      X_LO_(inverse(script.X_OL)),
      q_(script.joints),
      target_(X_WO),
      commanded_(X_WO) {
  if (q_.size() != arm_.value_count())
    throw InputError("arm '" + script.model + "': " + std::to_string(q_.size()) + " joint values for " +
                     std::to_string(arm_.value_count()) + " joints");
  if (!arm_.is_within_limits(q_)) throw InputError("arm '" + script.model + "': joint values out of limits");
  X_WL_.resize(arm_.links().size());
  next_ = q_;
  rates_.resize(q_.size());
  X_WB_ = rigid_frame(compose(X_WO, inverse(held_pose(q_))));
  target_ = held_pose(q_);
  figures_.is_arm = true;
}

Pose ArmHand::held_pose(std::span<const double> q) noexcept {
  arm_.link_poses(X_WB_, q, X_WL_);
  return compose(X_WL_[control_.link()], X_LO_);
}

void ArmHand::step_towards(const Pose& X_WO, double duration) noexcept {
  const Pose now = held_pose(q_);
  const Twist wanted = (1.0 / duration) * difference(now, X_WO);
  const ResolvedRate::Outcome outcome = control_.solve(X_WL_, now.p, wanted, rates_);
  double share = 1.0;
  for (const Mechanism::Joint& joint : arm_.joints()) {
    if (joint.value == Mechanism::kNone) continue;
    const double step = duration * rates_[joint.value], q = q_[joint.value];
    if (q + step > joint.upper) share = std::min(share, (joint.upper - q) / step);
    if (q + step < joint.lower) share = std::min(share, (joint.lower - q) / step);
  }
  for (std::size_t i = 0; i < q_.size(); ++i) next_[i] = q_[i] + share * (duration * rates_[i]);
  if (outcome.scale < 1.0 || share < 1.0) ++figures_.limited_frames;
  if (outcome.lambda > 0.0) ++figures_.damped_frames;
}

RigidPath ArmHand::command(const Pose& X_WO, const HandRates& rates, double duration) noexcept {
  // From where the hand asked it to be before, so that what a step leaves over is made good in the next.
  target_ = flown(target_, rates, duration).to();
  const std::size_t limited = figures_.limited_frames;
  step_towards(target_, duration);
  commanded_ = held_pose(next_);
  if (figures_.limited_frames != limited) target_ = commanded_;  // what cannot be done is not saved up
  return RigidPath::between(X_WO, commanded_);
}

void ArmHand::follow(const Pose& X_WO, double duration) noexcept {
  if (same(X_WO, commanded_)) {
    q_.swap(next_);
    return;
  }
  const HandFigures before = figures_;
  double left = length(difference(held_pose(q_), X_WO));
  for (int i = 0; i < kFollowSteps; ++i) {
    step_towards(X_WO, duration);
    const double then = length(difference(held_pose(next_), X_WO));
    if (!(then < left)) break;
    q_.swap(next_);
    left = then;
  }
  figures_ = before;
  figures_.largest_residual = std::max(figures_.largest_residual, left);
  target_ = commanded_ = X_WO;
}

std::unique_ptr<Hand> make_hand(const HandScript& script, const Pose& X_WO) {
  if (!script.arm) return std::make_unique<FreeHand>();
  try {
    return std::make_unique<ArmHand>(*script.arm, X_WO);
  } catch (const InputError& error) {
    throw InputError("hand on '" + script.object + "': " + error.what());
  }
}

}  // namespace touchstone::training
