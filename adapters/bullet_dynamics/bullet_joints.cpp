#include "touchstone/adapters/bullet_dynamics/bullet_joints.hpp"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics::bullet_dynamics {

using namespace TOUCHSTONE_BULLET_NAMESPACE;

namespace {

/// Bullet takes no infinity for a limit; a hinge's are angles within a turn.
constexpr double kNoLimit = 1e30, kNoStop = 1e6;
/// Axes of a hinge's and a slider's frames in Bullet.
constexpr int kHingeAxis = 2, kSliderAxis = 0;

Matrix3 with_axis(const Vector3& axis, int column) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(axis[i]) < std::abs(axis[least])) least = i;
  const Vector3 aside = cross(axis, Vector3(Vector3::Unit(least))), next = aside / norm(aside);
  Matrix3 R;
  R.col(column) = axis;
  R.col((column + 1) % 3) = next;
  R.col((column + 2) % 3) = cross(axis, next);
  return R;
}

Pose pose_of(const btRigidBody& body) { return from_engine(body.getWorldTransform()); }

}  // namespace

BodyJoint::BodyJoint(btDiscreteDynamicsWorld& world, const SceneBodyJoint& source, btRigidBody* child,
                     btRigidBody* parent, double step)
    : world_(world),
      source_(source),
      child_(child != nullptr ? *child : btTypedConstraint::getFixedBody()),
      parent_(parent != nullptr ? *parent : btTypedConstraint::getFixedBody()),
      step_(step) {
  const std::string who = " (joint '" + source_.name + "')";
  if (child == nullptr)
    throw InputError("engine 'bullet': unsupported: a child that is the ground" + who +
                     ": make it the parent");
  for (const double stop : {source_.lower, source_.upper})
    if (is_hinge() && std::isfinite(stop) && std::abs(stop) > std::numbers::pi)
      throw InputError("engine 'bullet': unsupported: a stop further than pi from the start" + who);
  if (is_hinge() && std::isfinite(source_.lower) != std::isfinite(source_.upper))
    throw InputError("engine 'bullet': unsupported: a hinge with a stop on one side alone" + who);
  Pose X_WJ;
  X_WJ.R = with_axis(source_.axis_W, is_slider() ? kSliderAxis : kHingeAxis);
  X_WJ.p = source_.p_W;
  X_PJ_ = compose(inverse(pose_of(parent_)), X_WJ);
  if (source_.is_on) make();
}

BodyJoint::~BodyJoint() { take_out(); }

void BodyJoint::take_out() {
  if (constraint_) world_.removeConstraint(constraint_.get());
  constraint_.reset();
}

Pose BodyJoint::X_WJ() const { return compose(pose_of(parent_), X_PJ_); }

void BodyJoint::switch_to(bool is_on) {
  take_out();
  if (is_on) make();
}

void BodyJoint::set_hold(const Hold& hold) {
  take_out();
  X_CJ_ = hold.X_CJ;
  if (hold.is_on) make_at(hold.X_CJ);
  value_ = hold.value, last_angle_ = hold.last_angle;
}

void BodyJoint::make() { make_at(compose(inverse(pose_of(child_)), X_WJ())); }

void BodyJoint::make_at(const Pose& X_CJ) {
  X_CJ_ = X_CJ;
  value_ = last_angle_ = 0.0;
  const btTransform on_parent = to_engine(X_PJ_), on_child = to_engine(X_CJ);
  if (is_hinge()) {
    auto hinge = std::make_unique<btHingeConstraint>(parent_, child_, on_parent, on_child, true);
    if (std::isfinite(source_.lower) || std::isfinite(source_.upper))  // the last figure: it would bounce
      hinge->setLimit(std::max(source_.lower, -std::numbers::pi), std::min(source_.upper, std::numbers::pi),
                      0.9, 0.3, 0.0);
    constraint_ = std::move(hinge);
  } else if (is_slider()) {
    auto slider = std::make_unique<btSliderConstraint>(parent_, child_, on_parent, on_child, true);
    slider->setLowerLinLimit(std::max(source_.lower, -kNoStop));
    slider->setUpperLinLimit(std::min(source_.upper, kNoStop));
    slider->setRestitutionLimLin(0.0);
    constraint_ = std::move(slider);
  } else if (source_.kind == BodyJointKind::ball) {
    constraint_ = std::make_unique<btPoint2PointConstraint>(parent_, child_, on_parent.getOrigin(),
                                                            on_child.getOrigin());
  } else {
    constraint_ = std::make_unique<btFixedConstraint>(parent_, child_, on_parent, on_child);
  }
  world_.addConstraint(constraint_.get(), true);
  apply_motor();
}

void BodyJoint::set_drive(const JointDrive& drive) {
  drive_ = drive;
  apply_motor();
}

void BodyJoint::apply_motor() {
  if (!constraint_ || !(is_hinge() || is_slider())) return;
  const bool has_motor = drive_.mode != JointDrive::Mode::torque;
  const double rate = drive_.mode == JointDrive::Mode::rate ? drive_.rate : 0.0;
  if (is_hinge()) {
    static_cast<btHingeConstraint&>(*constraint_)
        .enableAngularMotor(has_motor, rate, std::min(drive_.limit * step_, kNoLimit));
    return;
  }
  auto& slider = static_cast<btSliderConstraint&>(*constraint_);
  slider.setPoweredLinMotor(has_motor);
  slider.setTargetLinMotorVelocity(rate);
  slider.setMaxLinMotorForce(std::min(drive_.limit, kNoLimit));
}

void BodyJoint::apply() {
  if (!constraint_ || drive_.mode != JointDrive::Mode::torque || drive_.torque == 0.0) return;
  const Pose X = X_WJ();
  if (is_hinge()) {
    const btVector3 moment = to_engine(Vector3(drive_.torque * X.R.col(kHingeAxis)));
    child_.applyTorque(moment);
    parent_.applyTorque(-moment);
    return;
  }
  const btVector3 force = to_engine(Vector3(drive_.torque * X.R.col(kSliderAxis)));
  child_.applyForce(force, to_engine(Vector3(X.p - pose_of(child_).p)));
  parent_.applyForce(-force, to_engine(Vector3(X.p - pose_of(parent_).p)));
}

void BodyJoint::read() {
  if (!constraint_) return;
  if (is_slider()) {
    auto& slider = static_cast<btSliderConstraint&>(*constraint_);
    const Pose X_CJ = from_engine(slider.getFrameOffsetB());
    value_ = dot(X_WJ().R.col(kSliderAxis), transform(pose_of(child_), X_CJ.p) - X_WJ().p);
  }
  if (!is_hinge()) return;
  const double angle = static_cast<btHingeConstraint&>(*constraint_).getHingeAngle();
  value_ += std::remainder(angle - last_angle_, 2.0 * std::numbers::pi);
  last_angle_ = angle;
}

double BodyJoint::rate() const {
  if (!constraint_ || !(is_hinge() || is_slider())) return 0.0;
  const Pose X = X_WJ();
  if (is_hinge())
    return dot(X.R.col(kHingeAxis),
               from_engine(btVector3(child_.getAngularVelocity() - parent_.getAngularVelocity())));
  const auto at = [&](const btRigidBody& body) {
    return from_engine(body.getVelocityInLocalPoint(to_engine(Vector3(X.p - pose_of(body).p))));
  };
  return dot(X.R.col(kSliderAxis), at(child_) - at(parent_));
}

double BodyJoint::torque() const {
  if (!constraint_) return 0.0;
  if (drive_.mode == JointDrive::Mode::torque) return drive_.torque;
  return kNaN;  // Bullet sums it with what the joint holds
}

}  // namespace touchstone::physics::bullet_dynamics
