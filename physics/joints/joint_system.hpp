#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/physics/bodies/mechanism_dynamics.hpp"
#include "touchstone/physics/bodies/rigid_body.hpp"
#include "touchstone/physics/bodies/runge_kutta.hpp"
#include "touchstone/physics/joints/body_joint.hpp"
#include "touchstone/physics/joints/joint_equations.hpp"

/// @file
/// The motion of bodies and mechanisms that joints hold together, and the correction of errors that rounding
/// and long steps leave.

namespace touchstone::physics {

/// A set of bodies and mechanisms held together by BodyJoints, as index one system: at every stage of a
/// Runge-Kutta method of order 6 the joints' forces lambda make the rows' accelerations 0,
///
///     J M^-1 J^T lambda = -(J a + bias),   a what moves without them,
///
/// (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 8.3), so that the joints hold as exactly as
/// the motion is followed. Rows that repeat each other (a closed loop in a plane, a body held twice) leave
/// the forces undetermined: the ones taken have the least sum of squares, each row in units of its own
/// inertia, to 1e-6 of it. (Tikhonov's regularisation with iterated refinement: Hanke, Groetsch,
/// Nonstationary Iterated Tikhonov Regularization, 1998.) One order of operations; no allocation while no
/// system is larger than seen. One thread.
class JointSystem {
 public:
  /// A free body in flight.
  struct Body {
    const RigidBody* body;
    RigidBodyState state;
    Vector3 push_W = Vector3::Zero(),
            push_moment_W = Vector3::Zero();  ///< constant [N], [N m] about its centre
  };
  /// A mechanism in flight, its base held.
  struct Arm {
    const MechanismDynamics* dynamics;
    Pose X_WBase;
    std::span<const double> tau;  ///< constant over a flight
    std::span<double> q, qd;
    MechanismDynamics::Workspace* workspace;  ///< scratch
  };
  /// A kinematic body: its frame now, its velocities, constant.
  struct Kinematic {
    Pose X_WB;
    Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();
  };
  /// One side of a joint.
  struct Side {
    /// The kind that `index` counts; the ground has none.
    enum class Kind : std::uint8_t { ground, body, arm, kinematic } kind = Kind::ground;
    std::uint32_t index = 0;
    std::uint32_t link = 0;  ///< of an arm
  };
  /// A joint between two sides.
  struct Joint {
    const BodyJoint* joint;
    Side a, b;
  };

  std::vector<Body> bodies;
  std::vector<Arm> arms;
  std::vector<Kinematic> kinematic;
  std::vector<Joint> joints;

  void clear();
  /// Memory for this many at a time; of `arms` mechanisms of at most `widest` joint values. Systems of more
  /// than 64 joints get theirs when they come.
  void reserve(std::size_t bodies, std::size_t arms, std::size_t joints, std::size_t widest);

  /// Moves everything by h under gravity [m/s2]; kinematic bodies are left to the caller.
  /// @return false, states unchanged, where an arm's joint moves no inertia or the result is not finite.
  bool fly(double h, const Vector3& gravity_W);
  /// The joints' impulses in the last flight, on B, about the joint's origin, in world axes.
  struct Reaction {
    Vector3 impulse_W, twist_W;  ///< [N s], [N m s]
  };
  std::span<const Reaction> reactions() const { return reactions_; }

  /// Position projection: removes the rows' errors by the least motion in the metric of mass (a few steps of
  /// Newton's method); where joints conflict, the sum of squared errors, metres and radians alike, is least.
  /// Linear momenta keep their bits. Angular momenta change by what keeps the sum about any point, seen from
  /// the common centre of mass, where nothing is held from outside.
  /// @param most_correction the most that any row may be moved [m] [rad]. @return the largest error left.
  double pull_together(double most_correction);
  /// The largest error of any row as all stand [m] [rad].
  double worst_error();

 private:
  /// A body at a stage.
  struct Placed {
    Matrix3 R_WB, inverse_W;
    Vector3 p_W, v_W, w_W, a_W, alpha_W;
  };

  std::size_t size_of_unit(std::uint32_t unit) const;
  std::uint32_t unit_of(const Side& side) const;
  void place_bodies(const double* y, const Vector3& gravity_W);
  bool place_arms(const double* y, const Vector3& gravity_W);
  FrameMotion motion_of(const Side& side, double t) const;
  Vector3 point_acceleration(const Side& side, const Vector3& p_W, double t) const;
  Vector3 turn_acceleration(const Side& side) const;
  void add_rows(double t, bool with_accelerations);
  void add_side(const Side& side, const BodyJointRow& row, const Vector3& at_W, double sign, JointRow& out);
  void accelerations(double* slope) const;
  bool slope_at(double t, const double* y, double* slope, const Vector3& gravity_W);
  void start(double* y) const;
  bool take(const std::vector<double>& y, double h);
  double move_apart(double most_correction);

  Vector3 gravity_W_ = Vector3::Zero();
  std::vector<Placed> placed_;
  std::vector<std::size_t> first_rate_;  // by unit, in accelerations_
  std::vector<std::vector<double>> M_;   // by arm, factored
  std::vector<BodyJoint::Placed> placed_joints_;
  std::vector<JointRow> rows_;
  std::vector<double> J_, Y_;
  JointEquations equations_;
  std::vector<double> lambda_, rest_;
  std::vector<double> change_;  // by unit: M^-1 J^T lambda
  std::array<std::vector<double>, kRungeKuttaStages> slopes_;
  std::vector<double> y_, stage_;
  std::vector<Reaction> reactions_;
};

}  // namespace touchstone::physics
