#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "touchstone/contact_core/geometry/pose.hpp"

/// @file
/// Joints between bodies that have poses of their own: rows on the velocities of the two.

namespace touchstone::physics {

/// The freedom of B against A, by the z axis of the joint's frame.
enum class BodyJointKind : std::uint8_t {
  fixed,   ///< nothing
  hinge,   ///< turn about z
  slider,  ///< shift along z
  ball,    ///< turn
};
/// The enumerator's name.
std::string_view to_string(BodyJointKind kind);

/// How a frame M of a body moves.
struct FrameMotion {
  Pose X_WM;
  Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();  ///< of M's origin [m/s]; [rad/s]
};

/// A row of a joint: J of its velocity u = force . (v_B - v_A) + moment . (w_B - w_A), of both bodies' points
/// now at at_W. An impulse x of it acts as x force there and x moment on B, and backwards on A.
struct BodyJointRow {
  Vector3 force_W, moment_W;  ///< unit, or zero
  double error;               ///< what its velocity should have kept at 0 [m] or [rad]
  double bias;  ///< of du/dt, beside force . (a_B - a_A) + moment . (alpha_B - alpha_A) [m/s2], [rad/s2]
};

/// Two bodies held together at frames of theirs; z of both is the axis.
struct BodyJoint {
  BodyJointKind kind = BodyJointKind::fixed;
  Pose X_AJ, X_BJ;  ///< the joint's frame as A and B have it: one and the same in the world

  static constexpr std::size_t kMostRows = 6;

  /// A joint as its bodies stand.
  struct Placed {
    Vector3 at_W;    ///< where both bodies' forces act: B's joint frame's origin
    Vector3 axis_W;  ///< z of A's frame
    std::size_t count = 0;
    std::array<BodyJointRow, kMostRows> rows;
    double value = 0.0;  ///< of hinge [rad] from -pi to pi, of slider [m]; B against A
    double rate = 0.0;   ///< of it
  };
  /// Rows, fixed in A: translation along A's axes, then turns about them, those that the joint does not let.
  /// An error of a turn is the sine of its angle. (Featherstone, Rigid Body Dynamics Algorithms, 2008,
  /// chapter 8: a joint as constraints on relative velocity, and their bias.)
  Placed place(const FrameMotion& a, const FrameMotion& b) const;
  bool has_axis() const { return kind == BodyJointKind::hinge || kind == BodyJointKind::slider; }
};

/// @throws InputError `name`: frames that are no rigid transforms.
void validate(const BodyJoint& joint, std::string_view name);

}  // namespace touchstone::physics
