#include "touchstone/physics/joints/body_joint.hpp"

#include <string>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/geometry/trigonometry.hpp"

namespace touchstone::physics {
namespace {

/// Of a body's point now at p_W.
Vector3 velocity_at(const FrameMotion& body, const Vector3& p_W) {
  return body.v_W + cross(body.w_W, p_W - body.X_WM.p);
}

/// Which of the axes x, y, z are rows.
struct Held {
  std::array<bool, 3> shifts, turns;
};
Held held_by(BodyJointKind kind) {
  switch (kind) {
    case BodyJointKind::fixed:
      return {{true, true, true}, {true, true, true}};
    case BodyJointKind::hinge:
      return {{true, true, true}, {true, true, false}};
    case BodyJointKind::slider:
      return {{true, true, false}, {true, true, true}};
    case BodyJointKind::ball:
      return {{true, true, true}, {false, false, false}};
  }
  return {};
}

/// How B's frame is turned against A's, where that is little: the sine of the angle along its axis. Of a
/// hinge that of the two axes alone.
Vector3 turn_between(const Matrix3& R_WA, const Matrix3& R_WB, bool axes_alone) {
  if (axes_alone) return cross(Vector3(R_WA.col(2)), Vector3(R_WB.col(2)));
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < 3; ++i) sum += cross(Vector3(R_WA.col(i)), Vector3(R_WB.col(i)));
  return 0.5 * sum;
}

}  // namespace

std::string_view to_string(BodyJointKind kind) {
  constexpr std::array<std::string_view, 4> kNames{"fixed", "hinge", "slider", "ball"};
  return kNames[static_cast<std::size_t>(kind)];
}

BodyJoint::Placed BodyJoint::place(const FrameMotion& a, const FrameMotion& b) const {
  const Pose A = compose(a.X_WM, X_AJ), B = compose(b.X_WM, X_BJ);
  Placed out;
  out.at_W = B.p;
  out.axis_W = A.R.col(2);
  // The frames' relative offset and velocity are taken at B's origin.
  const Vector3 apart = B.p - A.p;
  const Vector3 v = velocity_at(b, B.p) - velocity_at(a, B.p), w = b.w_W - a.w_W;
  // A's axes turn with A: B has a Coriolis term, of its translation and of its rotation against A.
  const Vector3 coriolis = -2.0 * cross(a.w_W, v);
  const Vector3 turned = turn_between(A.R, B.R, kind == BodyJointKind::hinge);
  // Each translation and each rotation that is held gives a row.
  const Held held = held_by(kind);
  for (int i = 0; i < 3; ++i) {
    if (!held.shifts[static_cast<std::size_t>(i)]) continue;
    const Vector3 axis = A.R.col(i);
    out.rows[out.count++] = {axis, Vector3::Zero(), dot(axis, apart), dot(axis, coriolis)};
  }
  for (int i = 0; i < 3; ++i) {
    if (!held.turns[static_cast<std::size_t>(i)]) continue;
    const Vector3 axis = A.R.col(i);
    out.rows[out.count++] = {Vector3::Zero(), axis, dot(axis, turned), dot(w, cross(a.w_W, axis))};
  }
  // The free axis has a value and a rate.
  if (kind == BodyJointKind::hinge) {
    const Vector3 x_B = B.R.col(0);
    out.value = arc_tangent(dot(x_B, Vector3(A.R.col(1))), dot(x_B, Vector3(A.R.col(0))));
    out.rate = dot(out.axis_W, w);
  } else if (kind == BodyJointKind::slider) {
    out.value = dot(out.axis_W, apart);
    out.rate = dot(out.axis_W, v);
  }
  return out;
}

void validate(const BodyJoint& joint, std::string_view name) {
  validate_pose(joint.X_AJ, std::string(name) + ", frame on A");
  validate_pose(joint.X_BJ, std::string(name) + ", frame on B");
}

}  // namespace touchstone::physics
