#include "touchstone/adapters/ode_dynamics/ode_joints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics::ode_dynamics {
namespace {

Vector3 vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

}  // namespace

BodyBits bits_of(dBodyID body) {
  BodyBits out;
  std::copy_n(dBodyGetPosition(body), out.p.size(), out.p.begin());
  std::copy_n(dBodyGetLinearVel(body), out.v.size(), out.v.begin());
  std::copy_n(dBodyGetAngularVel(body), out.w.size(), out.w.begin());
  std::copy_n(dBodyGetQuaternion(body), out.q.size(), out.q.begin());
  std::copy_n(dBodyGetRotation(body), out.R.size(), out.R.begin());
  return out;
}

/// ODE lends its own numbers; the position's setter then tells the geoms.
void set_bits(dBodyID body, const BodyBits& bits) {
  std::copy(bits.q.begin(), bits.q.end(), const_cast<dReal*>(dBodyGetQuaternion(body)));
  std::copy(bits.R.begin(), bits.R.end(), const_cast<dReal*>(dBodyGetRotation(body)));
  dBodySetPosition(body, bits.p[0], bits.p[1], bits.p[2]);
  dBodySetLinearVel(body, bits.v[0], bits.v[1], bits.v[2]);
  dBodySetAngularVel(body, bits.w[0], bits.w[1], bits.w[2]);
}

OdeJoint::OdeJoint(dWorldID world, const EngineScene::Joint& joint, dBodyID child, dBodyID parent)
    : source_(joint.source), child_(child), value_(joint.source->value) {
  joint_ = is_hinge() ? dJointCreateHinge(world, nullptr) : dJointCreateSlider(world, nullptr);
  dJointAttach(joint_, child, parent);
  place(source_->p_W, source_->axis_W);
  dJointSetFeedback(joint_, &feedback_);
  const double lower = source_->lower - value_, upper = source_->upper - value_;
  for (const double stop : {lower, upper})
    if (is_hinge() && std::isfinite(stop) && std::abs(stop) > std::numbers::pi)
      throw InputError("engine 'ode': unsupported: a stop further than pi from the start (" + joint.name +
                       ")");
  // In this order: ODE keeps the lower one from being above the higher.
  if (std::isfinite(upper)) set(dParamHiStop, upper);
  if (std::isfinite(lower)) set(dParamLoStop, lower);
}

void OdeJoint::place(const Vector3& p_W, const Vector3& axis_W) {
  value_ = source_->value, last_angle_ = 0.0;
  if (!is_hinge()) return dJointSetSliderAxis(joint_, axis_W.x(), axis_W.y(), axis_W.z());
  dJointSetHingeAnchor(joint_, p_W.x(), p_W.y(), p_W.z());
  dJointSetHingeAxis(joint_, axis_W.x(), axis_W.y(), axis_W.z());
}

void OdeJoint::set(int parameter, double value) {
  if (is_hinge())
    dJointSetHingeParam(joint_, parameter, value);
  else
    dJointSetSliderParam(joint_, parameter, value);
}

void OdeJoint::set_drive(const JointDrive& drive) {
  drive_ = drive;
  const bool has_motor = drive.mode != JointDrive::Mode::torque;
  set(dParamVel, drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0);
  set(dParamFMax, has_motor ? (std::isfinite(drive.limit) ? drive.limit : dInfinity) : 0.0);
}

void OdeJoint::apply() {
  if (drive_.mode != JointDrive::Mode::torque || drive_.torque == 0.0) return;
  if (is_hinge())
    dJointAddHingeTorque(joint_, drive_.torque);
  else
    dJointAddSliderForce(joint_, drive_.torque);
}

void OdeJoint::read() {
  if (!is_hinge()) {
    value_ = source_->value + dJointGetSliderPosition(joint_);
    return;
  }
  const double angle = dJointGetHingeAngle(joint_);
  value_ += std::remainder(angle - last_angle_, 2.0 * std::numbers::pi);
  last_angle_ = angle;
}

double OdeJoint::rate() const {
  return is_hinge() ? dJointGetHingeAngleRate(joint_) : dJointGetSliderPositionRate(joint_);
}

/// Of what the joint did to the child, the part along the axis: a hinge's force acts at its anchor.
double OdeJoint::torque() const {
  if (drive_.mode == JointDrive::Mode::torque) return drive_.torque;
  dVector3 axis, anchor;
  const Vector3 force = vector_of(feedback_.f1);
  if (!is_hinge()) {
    dJointGetSliderAxis(joint_, axis);
    return dot(vector_of(axis), force);
  }
  dJointGetHingeAxis(joint_, axis);
  dJointGetHingeAnchor(joint_, anchor);
  const Vector3 lever = vector_of(anchor) - vector_of(dBodyGetPosition(child_));
  return dot(vector_of(axis), vector_of(feedback_.t1) - cross(lever, force));
}

OdeBodyJoint::OdeBodyJoint(dWorldID world, const EngineScene::BodyJoint& joint, dBodyID child, dBodyID parent)
    : source_(joint.source), child_(child), parent_(parent), p_P_(source_->p_W), axis_P_(source_->axis_W) {
  // ODE turns a joint round where the first body is the ground.
  if (child == nullptr)
    throw InputError("engine 'ode': unsupported: a child that is the ground (joint '" + source_->name +
                     "'): make it the parent");
  // Anchor and axis stay in the parent's frame, for when the joint holds again.
  if (parent_ != nullptr) {
    dVector3 p, axis;
    dBodyGetPosRelPoint(parent_, p_P_.x(), p_P_.y(), p_P_.z(), p);
    dBodyVectorFromWorld(parent_, axis_P_.x(), axis_P_.y(), axis_P_.z(), axis);
    p_P_ = vector_of(p), axis_P_ = vector_of(axis);
  }
  // Joints with an axis work as those of mechanisms do.
  const bool is_hinge = source_->kind == BodyJointKind::hinge;
  if (is_hinge || source_->kind == BodyJointKind::slider) {
    as_joint_.kind = is_hinge ? JointKind::revolute : JointKind::prismatic;
    as_joint_.p_W = source_->p_W, as_joint_.axis_W = source_->axis_W;
    as_joint_.lower = source_->lower, as_joint_.upper = source_->upper;
    axis_.emplace(world, EngineScene::Joint{{}, "joint '" + source_->name + "'", &as_joint_, 0, 0}, child,
                  parent);
    joint_ = axis_->id();
  } else {
    joint_ = source_->kind == BodyJointKind::ball ? dJointCreateBall(world, nullptr)
                                                  : dJointCreateFixed(world, nullptr);
    dJointAttach(joint_, child, parent);
  }
  switch_to(source_->is_on);
}

void OdeBodyJoint::switch_to(bool is_on) {
  is_on_ = is_on;
  placing_ = {is_on, ++placings_, bits_of(child_), {}};
  if (parent_ != nullptr) placing_.parent = bits_of(parent_);
  if (!is_on) return dJointDisable(joint_);
  dVector3 p = {p_P_.x(), p_P_.y(), p_P_.z()}, axis = {axis_P_.x(), axis_P_.y(), axis_P_.z()};
  if (parent_ != nullptr) {
    dBodyGetRelPointPos(parent_, p_P_.x(), p_P_.y(), p_P_.z(), p);
    dBodyVectorToWorld(parent_, axis_P_.x(), axis_P_.y(), axis_P_.z(), axis);
  }
  if (axis_)
    axis_->place(vector_of(p), vector_of(axis));
  else if (source_->kind == BodyJointKind::ball)
    dJointSetBallAnchor(joint_, p[0], p[1], p[2]);
  else
    dJointSetFixed(joint_);
  dJointEnable(joint_);
}

void OdeBodyJoint::place_again(const Placing& placing) {
  if (placing.number == placing_.number) return;
  set_bits(child_, placing.child);
  if (parent_ != nullptr) set_bits(parent_, placing.parent);
  switch_to(placing.is_on);
  placing_.number = placing.number;
}

}  // namespace touchstone::physics::ode_dynamics
