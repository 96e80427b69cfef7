#include "touchstone/physics/bodies/rigid_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"

namespace touchstone::physics {
namespace {

constexpr double kCutOff = 0x1p-55;
constexpr double kLargestAngle = 0.125;              // [rad] of one series
constexpr int kMostTerms = 19;                       // (1/8)^19 < kCutOff
using Series = std::array<Vector3, kMostTerms + 1>;  // coefficients by power of time over the step
using Attitudes = std::array<Quaternion, kMostTerms + 1>;

int terms_for(double angle) {
  int terms = 1;
  for (double rest = angle * angle; rest > kCutOff && terms < kMostTerms; rest *= angle) ++terms;
  return terms;
}

}  // namespace

bool is_finite(const RigidBodyState& state) {
  return touchstone::is_finite(state.p_W) && std::isfinite(state.q_WB.w) &&
         touchstone::is_finite(state.q_WB.v) && touchstone::is_finite(state.momentum_W) &&
         touchstone::is_finite(state.angular_W);
}

RigidBody::RigidBody(const BodyInertia& inertia, std::string_view name) : inertia_(inertia) {
  validate(inertia, Thinness::solid, name);
  inverse_B_ = symmetric_inverse(inertia.inertia_B);
  const Matrix3& I = inertia.inertia_B;
  gyration_ = std::sqrt(0.5 * ((I(0, 0) + I(1, 1)) + I(2, 2)) / inertia.mass);
}

RigidBodyState RigidBody::state(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W) const {
  RigidBodyState out;
  out.q_WB = quaternion_of(X_WB.R);
  out.p_W = touchstone::transform(X_WB, inertia_.centre_B);
  out.momentum_W = inertia_.mass * v_W;
  out.angular_W = rotate(turned(rotation_matrix(out.q_WB), inertia_.inertia_B), w_W);
  return out;
}

Pose RigidBody::pose(const RigidBodyState& state) const {
  Pose X_WB;
  X_WB.R = rotation_matrix(state.q_WB);
  X_WB.p = state.p_W - rotate(X_WB.R, inertia_.centre_B);
  return X_WB;
}

Vector3 RigidBody::angular_velocity(const RigidBodyState& state) const {
  return angular_velocity(rotation_matrix(state.q_WB), state.angular_W);
}

Vector3 RigidBody::angular_velocity(const Matrix3& R_WB, const Vector3& angular_W) const {
  return rotate(R_WB, rotate(inverse_B_, rotate_back(R_WB, angular_W)));
}

Matrix3 RigidBody::inverse_inertia_W(const RigidBodyState& state) const {
  return turned(rotation_matrix(state.q_WB), inverse_B_);
}

double RigidBody::kinetic_energy(const RigidBodyState& state) const {
  return 0.5 * (dot(state.momentum_W, state.momentum_W) / inertia_.mass +
                dot(state.angular_W, angular_velocity(state)));
}

void RigidBody::apply_impulse(RigidBodyState& state, const Vector3& impulse_W, const Vector3& at_W) {
  state.momentum_W += impulse_W;
  state.angular_W += cross(at_W - state.p_W, impulse_W);
}

bool RigidBody::fly(RigidBodyState& state, double h, const Vector3& gravity_W,
                    double kept_back) const noexcept {
  // The angular velocity follows from the angular momentum in the body's axes.
  Vector3 l_B = rotate_back(rotation_matrix(state.q_WB), state.angular_W);
  Vector3 w_B = rotate(inverse_B_, l_B);
  double rate = norm(w_B);
  if (!(rate * std::abs(h) <= kMostTurn)) return false;
  // The centre of mass moves on a parabola, which is exact.
  RigidBodyState next = state;
  add_compensated(next.p_W, next.p_low_W, h * (state.momentum_W / inertia_.mass + (0.5 * h) * gravity_W));
  add_compensated(next.momentum_W, next.low_W, (h * inertia_.mass) * gravity_W);
  // A turn too small to integrate is accumulated until it reaches `least`.
  const double least = least_turn(kept_back);
  if (rate * std::abs(h) < least) {
    turn_by(next, h * rotate(rotation_matrix(state.q_WB), w_B), least);
    rate = 0.0;
  }
  // A body may turn up to I_max / I_min faster in flight; each later series chooses its number of terms.
  for (double left = rate > 0.0 ? h : 0.0; left != 0.0;) {
    const double part =
        std::abs(left) * rate <= kLargestAngle ? left : std::copysign(kLargestAngle / rate, h);
    turn(next.q_WB, l_B, w_B, part);
    left -= part;
    if (left == 0.0) break;
    l_B = rotate_back(rotation_matrix(next.q_WB), next.angular_W);
    w_B = rotate(inverse_B_, l_B);
    rate = norm(w_B);
  }
  if (!is_finite(next)) return false;
  state = next;
  return true;
}

double RigidBody::least_turn(double kept_back) const {
  return std::max(kSmallestTurn, kept_back / gyration_);
}

void RigidBody::turn_by(RigidBodyState& state, const Vector3& angles_W, double least) {
  const Vector3 turn = state.turn_low_W + angles_W;
  const bool is_small = norm(turn) < least;
  state.turn_low_W = is_small ? turn : Vector3(Vector3::Zero());
  if (!is_small) state.q_WB = normalized(quaternion_of_turn(turn) * state.q_WB);
}

void RigidBody::keep_place(RigidBodyState& state, const RigidBodyState& from, double kept_back) const {
  const Vector3 displacement = (state.p_W - from.p_W) + state.p_low_W;
  if (!(norm(displacement) < std::max(kSmallestTurn * gyration_, kept_back))) return;
  state.p_W = from.p_W;
  state.p_low_W = displacement;
}

void RigidBody::turn(Quaternion& q, const Vector3& l_B, const Vector3& w_B, double h) const noexcept {
  Series l, w;  // angular momentum and h times the angular velocity, in B
  Attitudes a;
  a[0] = q;
  l[0] = l_B;
  w[0] = h * w_B;
  const int terms = terms_for(norm(w[0]));
  for (int k = 0; k < terms; ++k) {
    Vector3 torque = Vector3::Zero();
    Quaternion rate{0.0, Vector3::Zero()};
    for (int i = 0; i <= k; ++i) {
      torque += cross(l[i], w[k - i]);
      const Quaternion part = a[i] * Quaternion{0.0, w[k - i]};
      rate.w += part.w;
      rate.v += part.v;
    }
    l[k + 1] = torque / (k + 1);
    w[k + 1] = h * rotate(inverse_B_, l[k + 1]);
    a[k + 1] = {rate.w / (2.0 * (k + 1)), rate.v / (2.0 * (k + 1))};
  }
  Quaternion sum = a[terms];
  for (int k = terms; k-- > 0;) sum = {sum.w + a[k].w, sum.v + a[k].v};
  q = normalized(sum);
}

}  // namespace touchstone::physics
