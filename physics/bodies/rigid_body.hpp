#pragma once

#include <string_view>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/physics/bodies/inertia.hpp"

namespace touchstone::physics {

/// How a free-floating body moves. Momenta are the state, velocities follow from them: what acts on two
/// bodies is added to one and taken from the other, so that their sum stays to rounding, whatever the
/// attitude is.
struct RigidBodyState {
  Vector3 p_W = Vector3::Zero();         ///< centre of mass [m]
  Quaternion q_WB;                       ///< attitude of the body's frame
  Vector3 momentum_W = Vector3::Zero();  ///< linear [kg m/s]
  Vector3 angular_W = Vector3::Zero();   ///< angular, about the centre of mass, in world axes [N m s]
  Vector3 p_low_W = Vector3::Zero();     ///< Kahan compensation of p_W: what rounding took from it so far [m]
  Vector3 low_W = Vector3::Zero();       ///< the same of momentum_W [kg m/s]
  Vector3 turn_low_W = Vector3::Zero();  ///< turns too small for q_WB so far [rad]
};

/// True where position, attitude and momenta are; the compensations are not looked at.
bool is_finite(const RigidBodyState& state);

/// A rigid body that moves freely. Immutable; const use from several threads is safe. No allocation.
class RigidBody {
 public:
  /// @throws InputError as validate() for `solid`.
  RigidBody(const BodyInertia& inertia, std::string_view name);

  const BodyInertia& inertia() const { return inertia_; }

  /// @param X_WB a valid pose. @param v_W of the centre of mass [m/s]. @param w_W [rad/s].
  RigidBodyState state(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W) const;
  Pose pose(const RigidBodyState& state) const;
  Vector3 velocity(const RigidBodyState& state) const { return state.momentum_W / inertia_.mass; }
  Vector3 angular_velocity(const RigidBodyState& state) const;
  /// The same with the attitude's matrix at hand.
  Vector3 angular_velocity(const Matrix3& R_WB, const Vector3& angular_W) const;
  /// Inverse inertia about the centre of mass in world axes [1/(kg m2)].
  Matrix3 inverse_inertia_W(const RigidBodyState& state) const;
  double kinetic_energy(const RigidBodyState& state) const;  ///< [J]

  /// Adds an impulse [N s] at a point [m].
  static void apply_impulse(RigidBodyState& state, const Vector3& impulse_W, const Vector3& at_W);

  /// Free flight over `h` [s] under uniform gravity [m/s2]. The angular momentum keeps its bits; the linear
  /// one and the position follow their parabola, sums compensated (Kahan), so that rounding does not grow
  /// with the number of steps. The attitude is the Taylor series of Euler's equations and of dq/dt = q w / 2
  /// (both quadratic: coefficients by convolution; the method of Hairer, Norsett, Wanner, Solving Ordinary
  /// Differential Equations I, I.8), as many terms as keep what is cut off below 2^-55 of a turn.
  ///
  /// That many terms do: in principal axes |dw_i/dt| <= |w_j w_k|, since by the triangle inequality of the
  /// moments no |I_j - I_k| exceeds I_i. So w's k-th coefficient is at most sqrt(3) u^(k+1) with u = |w|, q's
  /// at most u^k, and what is left after N terms x^(N+1) / (1 - x), x = u h. Steps with x > 1/8 are divided.
  /// @param kept_back turns that move the body by less than this [m] are kept back, as by turn_by().
  /// @return false, the state unchanged, where the body would turn more than kMostTurn in the step or the
  /// result is not finite.
  bool fly(RigidBodyState& state, double h, const Vector3& gravity_W, double kept_back = 0.0) const noexcept;

  static constexpr double kMostTurn = 64.0;  ///< [rad]

  /// Turns by `angles_W` [rad]. Turns whose sum is below `least` accumulate in turn_low_W, so that a resting
  /// body's attitude keeps its bits. 2^-53 is less than the rounding of a point's position on the body.
  static void turn_by(RigidBodyState& state, const Vector3& angles_W, double least = kSmallestTurn);
  /// For turn_by(): the turn that moves the body by so much, at its radius of gyration [m]; at least 2^-53.
  double least_turn(double kept_back) const;
  /// The same of its position: back to `from`, the rest in p_low_W, where it moved from there by less than
  /// 2^-53 of the body's radius of gyration, or than `kept_back` [m].
  void keep_place(RigidBodyState& state, const RigidBodyState& from, double kept_back = 0.0) const;

 private:
  static constexpr double kSmallestTurn = 0x1p-53;  // [rad]

  void turn(Quaternion& q, const Vector3& l_B, const Vector3& w_B, double h) const noexcept;

  BodyInertia inertia_;
  Matrix3 inverse_B_;
  double gyration_;  // radius [m]
};

}  // namespace touchstone::physics
