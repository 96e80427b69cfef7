#include "touchstone/contact_core/motion/path.hpp"

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"

namespace touchstone {

RigidPath RigidPath::between(const Pose& from, const Pose& to) {
  RigidPath path;
  path.from_ = from;
  path.to_ = to;
  path.displacement_ = to.p - from.p;
  if (from.R == to.R) return path;
  // R_to = turn * R_from.
  const AxisAngle turn = axis_angle_of(quaternion_of(product(to.R, from.R.transpose())));
  path.axis_ = turn.axis;
  path.angle_ = turn.angle;
  return path;
}

RigidPath RigidPath::by(const Pose& from, const Vector3& displacement_W, const Vector3& turn_W,
                        const Vector3& centre_O) {
  RigidPath path;
  path.from_ = from;
  path.centre_O_ = centre_O;
  path.displacement_ = displacement_W;
  path.angle_ = norm(turn_W);
  if (path.angle_ > 0.0) path.axis_ = turn_W / path.angle_;
  path.to_ = path.along(1.0);
  return path;
}

RigidPath RigidPath::ending_at(const Pose& to) const {
  RigidPath path = *this;
  path.to_ = to;
  return path;
}

Pose RigidPath::along(double s) const noexcept {
  Pose X;
  if (angle_ == 0.0) {
    X.R = from_.R;
    X.p = from_.p + s * displacement_;
    return X;
  }
  X.R = product(rotation_about(axis_, s * angle_), from_.R);
  if (centre_O_ == Vector3::Zero()) {
    X.p = from_.p + s * displacement_;
  } else {
    X.p = (transform(from_, centre_O_) + s * displacement_) - rotate(X.R, centre_O_);
  }
  return X;
}

Pose RigidPath::pose_at(double s) const noexcept {
  if (s <= 0.0) return from_;
  if (s >= 1.0) return to_;
  return along(s);
}

BodyState RigidPath::at(std::uint32_t, double s) const noexcept {
  const Pose X_WO = pose_at(s);
  return {X_WO, transform(X_WO, centre_O_), displacement_, angle_ * axis_};
}

double RigidPath::curvature_bound(std::uint32_t, const BodyState& state, const Vector3& p_W,
                                  const Vector3& n_W) const noexcept {
  if (angle_ == 0.0) return 0.0;
  // n . (w x (w x r)) = -(w x n) . (w x r), and |w x r| stays as the point goes round.
  const Vector3& turn = state.angular_velocity_W;
  return norm(cross(turn, n_W)) * norm(cross(turn, p_W - state.centre_W));
}

MotionBounds RigidPath::bounds(std::uint32_t, const BodyState& state, const Vector3& p_W) const noexcept {
  const double turn = norm(state.angular_velocity_W);
  const double around = turn > 0.0 ? norm(cross(state.angular_velocity_W, p_W - state.centre_W)) : 0.0;
  return {norm(state.velocity_W) + around, turn * around, turn, 0.0};
}

BodyState CarriedPath::at(std::uint32_t body, double s) const noexcept {
  BodyState state = carrier_.at(0, s);
  const Pose& X_CO = list_ != nullptr ? (*list_)[body] : X_CO_[body];
  if (X_CO.p != Vector3::Zero() || X_CO.R != Matrix3::Identity()) state.X_WO = compose(state.X_WO, X_CO);
  return state;
}

double CarriedPath::curvature_bound(std::uint32_t, const BodyState& state, const Vector3& p_W,
                                    const Vector3& n_W) const noexcept {
  return carrier_.curvature_bound(0, state, p_W, n_W);
}

MotionBounds CarriedPath::bounds(std::uint32_t, const BodyState& state, const Vector3& p_W) const noexcept {
  return carrier_.bounds(0, state, p_W);
}

}  // namespace touchstone
