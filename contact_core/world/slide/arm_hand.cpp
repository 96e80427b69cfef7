#include "touchstone/contact_core/world/slide/arm_hand.hpp"

#include <algorithm>
#include <array>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/world/slide/slider.hpp"

namespace touchstone {
namespace {

Pose tool_pose(const MechanismMover& arm) { return compose(arm.X_WL[arm.hand->link], arm.hand->X_LT); }

Pose commanded_tool_pose(const MechanismMover& arm) {
  Pose X = arm.path.X_WB();
  for (const std::uint32_t j : arm.mechanism->chain(arm.hand->link)) {
    const Mechanism::Joint& joint = arm.mechanism->joints()[j];
    X = Mechanism::across(joint, X, joint.value == Mechanism::kNone ? 0.0 : arm.commanded[joint.value]);
  }
  return compose(X, arm.hand->X_LT);
}

/// By the spring of the tool frame, of two motions of it.
double spring_product(const ArmHand& hand, const Matrix3& R_WT, const Twist& a, const Twist& b) {
  const Vector3 v_a = rotate_back(R_WT, a.v), v_b = rotate_back(R_WT, b.v);
  const Vector3 w_a = rotate_back(R_WT, a.w), w_b = rotate_back(R_WT, b.w);
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    sum += hand.translation[i] * (v_a[i] * v_b[i]) + hand.turning[i] * (w_a[i] * w_b[i]);
  return sum;
}

}  // namespace

void weigh_by_hand(MechanismMover& arm) {
  ArmHand& hand = *arm.hand;
  const Pose X_WT = tool_pose(arm);
  const std::uint32_t base = arm.mechanism->base();
  arm.frame.set(arm.X_WL);
  const std::size_t size = arm.weights.size();
  std::array<Twist, kMostSlideJoints> J;
  for (std::uint32_t k = 0; k < size; ++k)
    J[k] = arm.frame.sign(k, hand.link, base) == 0 ? Twist{} : arm.frame.twist(k, X_WT.p);
  JointMatrix M;
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      M[i][j] = spring_product(hand, X_WT.R, J[i], J[j]) + (i == j ? arm.weights[i] : 0.0);
  find_root(M, arm.weights, hand.root);
}

void feel(const MechanismMover& arm, std::span<const SlideRow> rows, std::span<const JointRow> joint_rows,
          std::span<const int> active, Vector3& force_W, Vector3& moment_W) {
  force_W = moment_W = Vector3::Zero();
  std::array<JointRow, kMostSlideJoints> holding;
  for (std::size_t i = 0; i < active.size(); ++i) {
    holding[i] = joint_rows[active[i]];
    holding[i].slack = std::max(holding[i].slack, 0.0);
  }
  JointSlidePlan kept;
  if (!project_joints(joints_left(arm), arm.metric(), std::span(holding).first(active.size()), kept)) return;
  const Vector3 p_T = tool_pose(arm).p;
  for (int i = 0; i < kept.active_count; ++i) {
    const auto held_by = static_cast<std::size_t>(active[kept.active[i]]);
    if (held_by >= rows.size()) continue;  // a joint's stop
    const SlideRow& row = rows[held_by];
    if (row.other_link != arm.mechanism->base()) continue;
    const Vector3 f_W = kept.force[i] * row.n;
    force_W += f_W;
    moment_W += cross(row.r + arm.X_WL[row.link].p - p_T, f_W);
  }
}

HandFeel feel_of(const MechanismMover& arm, ObjectHandle object, const Vector3& force_W,
                 const Vector3& moment_W) {
  const Pose X_WT = tool_pose(arm), goal = commanded_tool_pose(arm);
  const Vector3 turn = RigidPath::between(X_WT, goal).at(0, 0.0).angular_velocity_W;
  return {object, X_WT.p, goal.p - X_WT.p, turn, force_W, moment_W};
}

}  // namespace touchstone
