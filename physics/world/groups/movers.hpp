#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <array>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/physics/joints/joint_system.hpp"
#include "touchstone/physics/world/dynamics_world.hpp"

// The bodies and mechanisms of a world, with the state that they have within a step.

namespace touchstone::physics::stepping {

/// The ground and kinematic bodies: nothing that a solve moves.
constexpr std::uint32_t kNoUnit = kNoIndex;

/// A free or kinematic body.
struct Body {
  RigidBody body;
  RigidBodyState state;
  bool is_kinematic = false, is_met = false, is_asleep = false, is_jointed = false;
  std::uint32_t first_sleeper = 0, next_sleeper = 0;  // a ring of those that sleep together
  double still_for = 0.0;                             // [s]
  Vector3 commanded_v_W = Vector3::Zero(), commanded_w_W = Vector3::Zero();  // kinematic
  Vector3 push_W = Vector3::Zero(), push_moment_W = Vector3::Zero();         // about its centre
  RigidBodyState kept = {};                                                  // before the step
  RigidBodyState start = {};                                                 // before the piece of the step
  RigidBodyState flown = {};  // after the piece, without impulses
  // Of the state, by Movers::update_motions().
  Pose X_WB = {};
  Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();
};

/// A joint's torques that rows find, and its rows: with the two end stops.
constexpr std::size_t kTorques = 3, kJointRows = 5;
enum class Torque : std::uint8_t { drive, friction, damping };

/// A mechanism. Vectors have an entry a joint value.
struct Arm {
  const MechanismDynamics* dynamics;
  Pose X_WBase;
  std::vector<double> q, qd, torque, start_torque, tau;
  std::vector<double> last_torque;  // by Torque, then joint value
  std::vector<double> change;       // of the rates, by the rows' impulses
  std::vector<double> M;            // the mass matrix, factored
  std::vector<double> reach;        // by joint value, with M: radius of gyration about the axis [m]; 1 or a
                                    // little more of one that shifts
  std::vector<double> kept_q, kept_qd, start_q, start_qd, flown_q, flown_qd;  // as Body's states
  std::vector<double> kept_torque, kept_last_torque;
  std::vector<double> push, turned;  // torques; scratch
  std::vector<JointDrive> drives;
  std::vector<JointLosses> losses;
  MechanismDynamics::Workspace placed, scratch;
  bool is_jointed = false;  // a joint between movers holds a link of it

  void place() { dynamics->place(X_WBase, q, qd, placed); }
};

/// A joint between movers, with the state that it has within a step.
struct HeldJoint {
  static constexpr std::size_t kRows = BodyJoint::kMostRows + kTorques;

  WorldJoint joint;
  double turns = 0.0;                   // of a hinge, in rad: its value is that of BodyJoint and these
  double value = 0.0, rate = 0.0;       // at the start of the piece
  std::array<double, kRows> last = {};  // impulses of the last piece over its length: held, then by Torque
  std::array<double, kRows> kept_last = {};  // before the step
  double kept_turns = 0.0;
  // Over the step, and at the start of the piece.
  double torque = 0.0, start_torque = 0.0;
  Vector3 impulse_W = Vector3::Zero(), twist_W = Vector3::Zero();
  Vector3 start_impulse_W = Vector3::Zero(), start_twist_W = Vector3::Zero();
  JointSystem::Reaction flown = {Vector3::Zero(), Vector3::Zero()};  // of the flight
  double duration = 0.0;                                             // of the step that these are of [s]
  BodyJoint::Placed placed = {};                                     // where rows have it
};

/// All that moves. Units number the bodies, then the mechanisms.
struct Movers {
  std::vector<Body> bodies;
  std::vector<Arm> arms;
  std::vector<HeldJoint> joints;
  JointSystem system;                        // scratch: a group's joints and what they hold
  std::vector<std::uint32_t> system_index;   // scratch, by unit: in it
  bool is_pushed = false;                    // something is
  std::uint32_t restless = 0, sleepers = 0;  // free bodies awake and kinematic ones that move; asleep

  std::size_t unit_count() const { return bodies.size() + arms.size(); }
  bool is_body(std::uint32_t unit) const { return unit < bodies.size(); }
  std::uint32_t unit_of_arm(std::uint32_t arm) const {
    return static_cast<std::uint32_t>(bodies.size()) + arm;
  }
  /// kNoUnit: the ground, a kinematic body.
  std::uint32_t unit_of(const Mover& mover) const {
    if (mover.kind == Mover::Kind::link) return unit_of_arm(mover.index);
    return mover.kind == Mover::Kind::body && !bodies[mover.index].is_kinematic ? mover.index : kNoUnit;
  }
  Arm& arm_of(std::uint32_t unit) { return arms[unit - bodies.size()]; }
  const Arm& arm_of(std::uint32_t unit) const { return arms[unit - bodies.size()]; }
  bool is_known(const Mover& mover) const;
  /// Whether it holds something that moves, and is awake.
  bool holds(const HeldJoint& joint) const;

  /// Poses and velocities from the states of these bodies.
  void update_motions(std::span<const std::uint32_t> bodies);
  /// Puts kinematic bodies where their command has them at that time, from their poses at the step's start,
  /// so that no group's clock matters. @param elapsed [s] of the step
  void place_kinematics(std::span<const std::uint32_t> kinematics, double elapsed);
  /// By the last update_motions().
  Pose pose_of(const Mover& mover) const;
  Vector3 point_velocity(const Mover& mover, const Vector3& p_W) const;

  /// Keeps all states for undo().
  void keep();
  /// Goes back to the start of the step.
  void undo();
  /// Ends the pushes: they were for one step.
  void forget_pushes();
};

}  // namespace touchstone::physics::stepping
