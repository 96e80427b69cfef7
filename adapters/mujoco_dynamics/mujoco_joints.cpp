#include "touchstone/adapters/mujoco_dynamics/mujoco_joints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics::mujoco_dynamics {
namespace {

/// Two unit vectors across a unit vector.
std::pair<Vector3, Vector3> across(const Vector3& z) {
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(z[k]) < std::abs(z[least])) least = k;
  Vector3 x = cross(z, Vector3(Vector3::Unit(least)));
  x = x / norm(x);
  return {x, cross(z, x)};
}

void require_supported(const SceneBodyJoint& joint) {
  const auto refuse = [&](const std::string& what) {
    throw InputError("engine 'mujoco': unsupported: " + what + " (joint '" + joint.name + "')");
  };
  if (joint.kind == BodyJointKind::slider) refuse("sliders between bodies");
  if (std::isfinite(joint.lower) || std::isfinite(joint.upper)) refuse("stops of joints between bodies");
  if (joint.losses.friction > 0.0 || joint.losses.damping > 0.0) refuse("losses of joints between bodies");
  if (joint.drive.drive.mode != JointDrive::Mode::torque) refuse("motors of joints between bodies");
}

/// Whether a constraint is on is the data's in later versions, the model's before.
template <class Model, class Data>
void set_active(Model& model, Data& data, int constraint, bool is_on) {
  if constexpr (requires { data.eq_active[constraint] = 1; })
    data.eq_active[constraint] = is_on ? 1 : 0;
  else
    model.eq_active[constraint] = is_on ? 1 : 0;
}

}  // namespace

std::vector<Vector3> shared_points(const EngineScene& scene, const EngineScene::BodyJoint& joint) {
  const SceneBodyJoint& source = *joint.source;
  require_supported(source);
  if (joint.child == EngineScene::kNone)
    throw InputError("engine 'mujoco': unsupported: a child that is the ground (joint '" + source.name +
                     "'): make it the parent");
  const EngineScene::Body& child = scene.bodies()[joint.child];
  const double sum = child.moments.x() + child.moments.y() + child.moments.z();
  const double radius = child.mass > 0.0 && sum > 0.0 ? std::sqrt(0.5 * sum / child.mass) : 1.0;
  const auto [x, y] = across(source.axis_W);
  if (source.kind == BodyJointKind::ball) return {source.p_W};
  if (source.kind == BodyJointKind::hinge)
    return {source.p_W + radius * source.axis_W, source.p_W - radius * source.axis_W};
  const double half = 0.5 * radius, side = 0.5 * std::numbers::sqrt3 * radius;
  return {source.p_W + radius * x, source.p_W - half * x + side * y, source.p_W - half * x - side * y};
}

std::string connect_name(std::size_t joint, std::size_t point) {
  return "e" + std::to_string(joint) + "_" + std::to_string(point);
}

BodyJoint::BodyJoint(const EngineScene& scene, std::size_t joint, const mjModel& model)
    : source_(&scene.body_joints()[joint]) {
  const bool on_ground = source_->parent == EngineScene::kNone;
  const Pose X_WP = on_ground ? Pose{} : scene.bodies()[source_->parent].X_WB;
  const Pose& X_WC = scene.bodies()[source_->child].X_WB;
  axis_P_ = rotate_back(X_WP.R, source_->source->axis_W);
  state_.R_PC = product(Matrix3(X_WP.R.transpose()), X_WC.R);
  for (std::size_t k = 0; k < shared_points(scene, *source_).size(); ++k) {
    ids_.push_back(mj_name2id(&model, mjOBJ_EQUALITY, connect_name(joint, k).c_str()));
    std::array<mjtNum, 6> points{};
    std::copy_n(model.eq_data + static_cast<std::ptrdiff_t>(mjNEQDATA) * ids_.back(), 6, points.begin());
    state_.points.push_back(points);
  }
}

void BodyJoint::tell(mjModel& model, mjData& data) const {
  for (std::size_t k = 0; k < ids_.size(); ++k) {
    std::copy_n(state_.points[k].begin(), 6,
                model.eq_data + static_cast<std::ptrdiff_t>(mjNEQDATA) * ids_[k]);
    set_active(model, data, ids_[k], state_.is_on);
  }
}

void BodyJoint::switch_to(bool is_on, mjModel& model, mjData& data, const Side& child, const Side& parent) {
  state_.is_on = is_on;
  if (is_on) {
    const Pose X_CP = compose(inverse(child.X_WB), parent.X_WB);
    for (std::array<mjtNum, 6>& point : state_.points) {
      const Vector3 p_C = transform(X_CP, Vector3(point[3], point[4], point[5]));
      for (int i = 0; i < 3; ++i) point[static_cast<std::size_t>(i)] = p_C[i];
    }
    state_.R_PC = product(Matrix3(parent.X_WB.R.transpose()), child.X_WB.R);
    state_.value = state_.last_angle = 0.0;
  }
  tell(model, data);
}

void BodyJoint::read(const Side& child, const Side& parent) {
  rate_ = 0.0;
  if (!state_.is_on || !has_axis()) return;
  const Vector3 axis = axis_W(parent);
  rate_ = dot(axis, Vector3(child.w_W - parent.w_W));
  // From where the child's axes would be at value 0 to where they are, about the axis.
  const Matrix3 R_at_0 = product(parent.X_WB.R, state_.R_PC);
  const auto [x, y] = across(axis_P_);
  const Vector3 x_W = rotate(parent.X_WB.R, x), y_W = rotate(parent.X_WB.R, y);
  const Vector3 turned = rotate(child.X_WB.R, rotate_back(R_at_0, x_W));
  const double angle = std::atan2(dot(turned, y_W), dot(turned, x_W));
  state_.value += std::remainder(angle - state_.last_angle, 2.0 * std::numbers::pi);
  state_.last_angle = angle;
}

void BodyJoint::set_state(const State& state, mjModel& model, mjData& data) {
  state_ = state;
  tell(model, data);
}

}  // namespace touchstone::physics::mujoco_dynamics
