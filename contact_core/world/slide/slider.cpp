#include "touchstone/contact_core/world/slide/slider.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone {
namespace {

/// Of the room between two sliders neither gets less than this share, whatever their commands.
constexpr double kLeastShare = 0.125;

/// How fast a slider would come along n if it went straight to its goal.
double rate_along(const Vector3& n, const Vector3& p_W, const Pose& X_WR, const Slider& slider) {
  const Twist twist = twist_to_goal(slider, X_WR);
  return dot(n, twist.v + cross(twist.w, p_W - transform(X_WR, slider.metric.centre)));
}

double share_of(double rate, double other_rate) {
  const double approach = std::max(rate, 0.0), other = std::max(other_rate, 0.0);
  if (approach == other) return 0.5;
  return std::clamp(approach / (approach + other), kLeastShare, 1.0 - kLeastShare);
}

}  // namespace

double Slider::turn_rate() const { return 1.0 / std::sqrt(least_inertia(metric.J)); }

Twist twist_to_goal(const Slider& slider, const Pose& X_WR) {
  const BodyState start = RigidPath::between(X_WR, slider.goal).at(0, 0.0);
  return {transform(slider.goal, slider.metric.centre) - transform(X_WR, slider.metric.centre),
          start.angular_velocity_W};
}

TwistMetric metric_at(const Slider& slider, const Pose& X_WR) {
  const Matrix3 J_W = turned(X_WR.R, slider.metric.J);
  return slider.is_even ? TwistMetric(J_W) : TwistMetric(J_W, slider.K_W);
}

double distance_to_goal(const Slider& slider, const Pose& X_WR) {
  const Twist left = twist_to_goal(slider, X_WR);
  return std::sqrt(inner_product(metric_at(slider, X_WR), left, left));
}

double distance_left(const Slider& slider, const Pose& X_WR) {
  if (slider.arm == nullptr) return distance_to_goal(slider, X_WR);
  const JointVector left = joints_left(*slider.arm);
  return std::sqrt(joint_product(left, left, slider.arm->metric()));
}

JointVector joints_left(const MechanismMover& arm) {
  JointVector left{};
  for (std::size_t k = 0; k < arm.actual.size(); ++k) left[k] = arm.commanded[k] - arm.actual[k];
  return left;
}

void weigh_by_hand(Slider& slider, const std::optional<HandStiffness>& hand) {
  slider.metric = mass_metric(slider.moments);
  if (!hand) return;
  const Pose X_RT = hand->X_OT.value_or(Pose{});
  if (hand->X_OT) slider.metric.centre = X_RT.p;
  const Vector3 &k = hand->translation, &c = hand->turning;
  slider.stiffness = k.minCoeff();
  const auto diagonal = [&](const Vector3& values) {
    Matrix3 out = Matrix3::Zero();
    for (int i = 0; i < 3; ++i) out(i, i) = values[i] / slider.stiffness;
    return turned(X_RT.R, out);
  };
  slider.metric.J = diagonal(c);
  slider.is_even = k.x() == k.y() && k.y() == k.z();
  if (!slider.is_even) slider.K_W = turned(slider.goal.R, diagonal(k));
}

double share_between(const Slider& slider, const Pose& X_WR, const Slider& other, const Pose& X_WR_other,
                     const NearPair& near) {
  if (slider.arm != nullptr || other.arm != nullptr) return 0.5;
  return share_of(-rate_along(near.n, near.points[0].p_B_W, X_WR, slider),
                  rate_along(near.n, near.points[0].p_A_W, X_WR_other, other));
}

bool shares_room(std::span<const NearPair> near) {
  return std::any_of(near.begin(), near.end(), [](const NearPair& pair) { return pair.share < 1.0; });
}

bool leaves_little(const Slider& slider, double left_over) {
  return left_over <= 2.0 * kLeastGain * slider.start_distance * slider.distance;
}

}  // namespace touchstone
