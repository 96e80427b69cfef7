#include "touchstone/adapters/ode_dynamics/ode_joints.hpp"

#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics::ode_dynamics {
namespace {

Vector3 vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

}  // namespace

OdeJoint::OdeJoint(dWorldID world, const EngineScene::Joint& joint, dBodyID child, dBodyID parent)
    : source_(joint.source), child_(child), value_(joint.source->value) {
  const Vector3 &p = source_->p_W, &axis = source_->axis_W;
  joint_ = is_hinge() ? dJointCreateHinge(world, nullptr) : dJointCreateSlider(world, nullptr);
  dJointAttach(joint_, child, parent);
  if (is_hinge()) {
    dJointSetHingeAnchor(joint_, p.x(), p.y(), p.z());
    dJointSetHingeAxis(joint_, axis.x(), axis.y(), axis.z());
  } else {
    dJointSetSliderAxis(joint_, axis.x(), axis.y(), axis.z());
  }
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

}  // namespace touchstone::physics::ode_dynamics
