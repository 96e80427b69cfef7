#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/bodies/mechanism_dynamics.hpp"
#include "touchstone/physics/bodies/rigid_body.hpp"
#include "touchstone/physics/joints/body_joint.hpp"
#include "touchstone/physics/solver/contact_solver.hpp"

/// @file
/// Bodies and mechanisms that push each other at contact points, which any narrowphase may have found.
///
/// Threads: one thread owns a world; different worlds share nothing. Set-up throws InputError and changes
/// nothing; step() neither throws nor, once as many contacts as reserved for have been seen, allocates.

namespace touchstone::physics {

/// One side of a contact.
struct Mover {
  /// The ground never moves.
  enum class Kind : std::uint8_t { ground, body, link };
  Kind kind = Kind::ground;
  std::uint32_t index = 0;  ///< of the body or the mechanism, as add_...() returned
  std::uint32_t link = 0;   ///< of the mechanism

  static Mover ground() { return {}; }
  static Mover of_body(std::uint32_t body) { return {Kind::body, body, 0}; }
  static Mover of_link(std::uint32_t mechanism, std::uint32_t link) { return {Kind::link, mechanism, link}; }
  friend bool operator==(const Mover&, const Mover&) = default;
};

/// A contact point at the start of a step, in the narrowphase's words (ContactPoint).
struct Contact {
  Mover a, b;
  Vector3 n_AB_W;            ///< unit, from A to B
  Vector3 p_A_W, p_B_W;      ///< on the surfaces [m]; p_B_W = p_A_W + separation n_AB_W
  double friction = 0.0;     ///< Coulomb, >= 0
  double restitution = 0.0;  ///< Newton's, 0 to 1
  std::uint64_t key =
      0;  ///< names the pair and its feature from step to step: what was found last is tried first
  /// By which each surface is rounded there, >= 0 [m]: contact goes along with what rolls.
  double radius_A = 0.0, radius_B = 0.0;
};

/// How a joint is driven. The torque of `rate`, `brake` and `position` is whatever the motion takes, up to
/// the limit: it is found together with the contact forces.
struct JointDrive {
  /// Meaning of `torque`, `rate` and `limit`.
  enum class Mode : std::uint8_t {
    torque,    ///< applies `torque`, cut to +-limit
    rate,      ///< follows `rate` with at most `limit`
    brake,     ///< holds with at most `limit`
    position,  ///< stiffness (position - value) + damping (rate - the joint's), cut to +-limit
  };
  Mode mode = Mode::torque;
  double torque = 0.0;       ///< [N m] or [N]
  double rate = 0.0;         ///< [rad/s] or [m/s]
  double limit = kInfinity;  ///< >= 0
  // Of position alone. The torque is that of a weighted mean of the step's start and end, so that it settles
  // for any stiffness and step, and is exact where damping alone acts (solver/implicit_share.hpp); as a
  // compliant row of the contact problem (Castro, Permenter, Han 2022; Drake's SapPdControllerConstraint).
  double position = 0.0;   ///< [rad] or [m]
  double stiffness = 0.0;  ///< >= 0 [N m/rad] or [N/m]
  double damping = 0.0;    ///< >= 0 [N m s/rad] or [N s/m]
};

/// The passive losses of a joint, whatever drives it.
struct JointLosses {
  double friction = 0.0;  ///< Coulomb's: holds, or acts against the rate with, so much [N m] or [N], >= 0
  double damping = 0.0;   ///< against the rate [N m s/rad] or [N s/m], >= 0; implicit as a position drive's
};

/// A joint between two movers: bodies, links, the ground, kinematic bodies. Frames of bodies are those of
/// RigidBody::pose(), of links Mechanism's, of the ground the world's. Loops may be closed by it.
struct WorldJoint {
  Mover a = {}, b = {};
  BodyJoint joint = {};
  // Of hinges and sliders, by their value: B against A, about or along z of A's frame. Hinges count turns.
  double lower = -kInfinity;  ///< [rad] or [m]
  double upper = kInfinity;
  JointDrive drive = {};
  JointLosses losses = {};
  bool is_on = true;  ///< it holds
};

/// The state of a joint of the world.
struct WorldJointState {
  double value = 0.0, rate = 0.0;      ///< of hinges and sliders [rad, rad/s] or [m, m/s]
  double error = 0.0;                  ///< the farthest that any direction is off [m] or [rad]
  double torque = 0.0;                 ///< of its drive, mean over the last step [N m] or [N]
  Vector3 force_W = Vector3::Zero();   ///< that it put on B, mean over the last step, drives apart [N]
  Vector3 moment_W = Vector3::Zero();  ///< the same, about B's joint frame's origin [N m]
};

/// Force and impulse of one contact over a step.
struct ContactForce {
  Vector3 force_W;   ///< mean over the step, on B [N]; impacts included
  Vector3 impact_W;  ///< the impulse of impacts alone, on B [N s]
};

/// Force and moment of contacts on one body or link, about the world's origin.
struct Wrench {
  Vector3 force_W = Vector3::Zero();   ///< [N]
  Vector3 moment_W = Vector3::Zero();  ///< [N m]
};
/// Sum over the contacts of a step and what DynamicsWorld::step() wrote for them; each acts in the middle
/// between its points. @pre one force a contact.
Wrench wrench_on(const Mover& mover, std::span<const Contact> contacts, std::span<const ContactForce> forces);

/// Why a step was not taken.
enum class StepFailure : std::uint8_t {
  none,
  bad_step,     ///< its length is not positive and finite
  bad_contact,  ///< a contact that names nothing, a normal that is not unit, figures out of range
  body,         ///< a body's state would not be finite
  turn,         ///< a body would turn by more than RigidBody::kMostTurn
  mechanism,    ///< a mechanism's values or rates would not be finite, or a joint moves no inertia
  latch,        ///< of SceneSimulation: see begin_step()
};
/// The enumerator's name.
std::string_view to_string(StepFailure failure);
/// A predicate of the contact, body, mechanism or object that StepReport::failed_index names: "its state
/// would not be finite".
std::string_view reason_of(StepFailure failure);

/// How a step went. Solves, sweeps and Newton steps are sums; residual and pieces are the largest of any
/// group.
struct StepReport {
  /// If any, the world is as before the step to the bit, what the next step starts from included, and no
  /// force was written.
  StepFailure failure = StepFailure::none;
  std::uint32_t failed_index = 0;  ///< of the contact, body or mechanism; latch: of the object
  double worst_residual = 0.0;     ///< of all solves [m/s]; see natural_residual()
  std::uint32_t solves = 0, unconverged = 0, sweeps = 0, newton_steps = 0;
  std::uint32_t contradictory = 0;  ///< solves whose contacts no impulses satisfy: they yield, and press hard
  /// The largest error of any joint between movers at the step's end [m] or [rad]: above the contact gap they
  /// contradict each other, and least squares share it out, or they come together still.
  double worst_joint_error = 0.0;
  bool is_work_spent = false;  ///< the step went on with what was found when its work ended
  std::uint32_t substeps = 0;  ///< pieces the step was cut into: impacts and stops are located in time
  double last_stop = kNaN;     ///< when within the step sliding or a braked
                               ///< joint last stopped [s]
};

/// Free and kinematic bodies and mechanisms under gravity, drives and contacts, stepped in time. Threads and
/// errors: see dynamics_world.hpp. A copy is a snapshot: assigned back, and given contacts found anew, it
/// takes the same steps to the bit (but for links' inertias, which are MechanismDynamics' own).
class DynamicsWorld {
 public:
  /// How long contact problems are solved.
  enum class Accuracy : std::uint8_t {
    /// As long as the step's work lasts. In one piece go groups of more than 21 points; of bodies alone that
    /// overlap, or whose contacts were lately proven to contradict each other; and the rest of a step one of
    /// whose solves did not converge.
    bounded,
    exact,  ///< by every means of ContactSolver, however long that takes
  };

  /// The same for every step. Figures that are not finite, a gap or tolerance that is not > 0, speeds, rates
  /// or counts below 0, and no pieces, rounds or island sweeps are an InputError.
  struct Settings {
    Vector3 gravity_W = Vector3::Zero();  ///< [m/s2]
    double contact_gap = 1e-9;            ///< closer than this [m] (joint stops: rad or m) counts as touching
    double bounce_speed = 1e-3;           ///< approaches slower than this [m/s] do not bounce
    /// Rate of position correction [1/s]: overlap deeper than 100 000 gaps (0.1 mm) parts at this rate times
    /// its depth, at 1 mm/s at least (0: not at all) and at `part_speed` [m/s] at most. It is moved,
    /// and gets no momentum by it: a group's linear and angular momentum stay, and bodies of a free group may
    /// turn about its centre for that. Deeper overlap that a step itself makes is removed at its end.
    double push_out = 5.0, part_speed = 0.05;
    /// Bodies that contacts join and that have moved slower than `sleep_speed` [m/s] for `sleep_time` [s]
    /// sleep: they have no momentum, and are not looked at until something awake comes near or one of them is
    /// commanded to move. Infinite: nothing sleeps. A body's speed is its centre's and, for its turning, |w|
    /// sqrt(tr I / m).
    double sleep_speed = 1e-3, sleep_time = kInfinity;
    std::uint32_t most_substeps = 16;  ///< then contacts of the rest of the step are met without bouncing
    ContactSolver::Settings solver = {};
    Accuracy accuracy = Accuracy::bounded;
    /// Work that Accuracy::bounded may take in a step for what contacts and joints hold together, before it
    /// goes on with the best found so far, which is said: this many thousand multiplications for each
    /// contact, eight of them a body at most, half as many for each beyond 64, as for six contacts for each
    /// joint, and as for 18 at least; as many again for parting what overlaps. More than 64 contacts of
    /// bodies alone that come to rest count all, and twice: none overlaps by more than 0.1 mm, is touched by
    /// what is commanded to move, or is faster than gravity makes it in two steps. Bodies of masses up to 4
    /// to 1 with up to 64 contacts have half of it while they are parted, and four times as much where they
    /// are as slow as that on what slides beneath them without carrying them (a queue on a belt; without
    /// gravity none are). Each further millisecond of the step, up to 16 in all, gives as for 18 more to all
    /// of these together that need it; bodies of masses up to 4 to 1 take as much of it as they have, none
    /// with more than 64 contacts or while they are parted. Bodies of masses that differ by 1e3 or 1e6 have 2
    /// and 4.5 times as much, and their islands' rounds take 2 and 4 times as long. A thousand take some 0.5
    /// us.
    double work = 8.0;
    /// The same by the clock [us], for live use: results then depend on the machine. Infinite: not looked at.
    double most_microseconds = kInfinity;
  };

  explicit DynamicsWorld(const Settings& settings);
  ~DynamicsWorld();
  /// Copies all but the mechanisms' MechanismDynamics, which both keep references to. Assigning to a world of
  /// as many bodies and contacts does not allocate.
  DynamicsWorld(const DynamicsWorld& other);
  DynamicsWorld& operator=(const DynamicsWorld& other);
  /// The other may then only be assigned to.
  DynamicsWorld(DynamicsWorld&& other) noexcept;
  DynamicsWorld& operator=(DynamicsWorld&& other) noexcept;

  /// A free body. @throws InputError as RigidBody; a state that is not finite.
  std::uint32_t add_body(const RigidBody& body, const RigidBodyState& state);
  /// A kinematic body: it moves as commanded, as if of infinite mass. @throws InputError for a bad pose,
  /// velocities that are not finite.
  std::uint32_t add_kinematic(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W);
  /// Keeps a reference. All joints are free (torque 0) within their limits.
  /// @throws InputError: another number of values, values out of the joints' limits or not finite.
  std::uint32_t add_mechanism(const MechanismDynamics& dynamics, const Pose& X_WBase,
                              std::span<const double> q, std::span<const double> qd);
  /// A commanded rate is cut to the joint's own limit.
  /// @throws InputError: an unknown mechanism or joint value, a limit, stiffness or damping below 0, figures
  /// that are not finite.
  void set_drive(std::uint32_t mechanism, std::uint32_t value, const JointDrive& drive);
  /// Friction and damping of a joint: not counted among its drive's torques.
  /// @throws InputError: an unknown mechanism or joint value, figures below 0 or not finite.
  void set_losses(std::uint32_t mechanism, std::uint32_t value, const JointLosses& losses);
  /// Joins two movers from now on. Its frames may stand apart: they come together at part_speed at most,
  /// without momentum; velocities that it does not allow are stopped by impulses at the next step's start, as
  /// in a capture. Wakes both. The contacts of what it joins are the caller's to leave out. @return its
  /// number.
  /// @throws InputError: no such body or link, one mover twice (two links of a mechanism may be joined),
  /// neither one free, frames that are no rigid transforms, limits that are crossed or of a joint without an
  /// axis, or with a hinge beyond 64 turns, figures as of set_drive() and set_losses().
  std::uint32_t add_joint(const WorldJoint& joint);
  /// Lets go, or holds again at the frames that it has. Does not allocate. @throws InputError: no such joint.
  void switch_joint(std::uint32_t joint, bool is_on);
  /// Holds from now on as the two stand: B's frame becomes where A's is, the value 0. Does not allocate.
  /// @throws InputError: no such joint.
  void join_as_they_stand(std::uint32_t joint);
  /// Drives a hinge or slider. @throws InputError: no such joint, one without an axis, figures as of
  /// set_drive().
  void set_joint_drive(std::uint32_t joint, const JointDrive& drive);
  std::size_t joint_count() const;
  const WorldJoint& world_joint(std::uint32_t joint) const;
  WorldJointState joint_state(std::uint32_t joint) const;
  /// Velocities of a kinematic body from now on. @throws InputError: not one.
  void set_velocity(std::uint32_t kinematic, const Vector3& v_W, const Vector3& w_W);
  /// Replaces a free body and its state, as after a latch or a release; also of one that was held out.
  /// @throws InputError: no such body, a state that is not finite. Does not allocate.
  void set_body(std::uint32_t body, const RigidBody& as, const RigidBodyState& state);
  /// Takes a body out of the world until set_body(): it keeps its pose and has no momentum. @pre no contact
  /// names it.
  void hold_out(std::uint32_t body);
  /// Joint rates from now on (joint_rates() itself, too), and the links' inertias taken anew
  /// (MechanismDynamics::set_links()). Does not allocate. @pre one a joint value, finite.
  void set_rates(std::uint32_t mechanism, std::span<const double> qd);
  /// Joint values and rates from now on, as when something outside has stopped the mechanism. Does not
  /// allocate. @pre one each a joint value, finite, the values within the joints' limits.
  void set_joints(std::uint32_t mechanism, std::span<const double> q, std::span<const double> qd);
  /// Over the next step that is taken, beside gravity, drives and contacts: a force at p_W and a moment, both
  /// constant, the point going along with the body. Several add up. Wakes what sleeps. On a link: the joint
  /// torques that they come to where it is now, beyond its drives' limits and not counted among their
  /// torques. Does not allocate.
  /// @param force_W [N] @param p_W [m] @param moment_W [N m]
  /// @throws InputError: the ground, a kinematic body, no such body or link, figures that are not finite.
  void push(const Mover& mover, const Vector3& force_W, const Vector3& p_W,
            const Vector3& moment_W = Vector3::Zero());
  /// Takes back all calls of push() since the last step.
  void forget_pushes();
  /// Wakes a free body and all bodies of its sleeping group.
  void wake(std::uint32_t body);
  bool is_asleep(std::uint32_t body) const;
  /// The first body of its sleeping group. @pre it is asleep
  std::uint32_t first_of_sleepers(std::uint32_t body) const;
  std::uint32_t sleepers() const;  ///< bodies
  /// Whether every free body sleeps, nothing else moves, and there are no mechanisms.
  bool is_at_rest() const;
  /// Whether what touches it is to be looked at: not ground, sleepers, and kinematic bodies that stand.
  bool is_restless(const Mover& mover) const;
  /// Reserves memory for this many contacts at a time, and for all joint rows, and writes 8 MiB of
  /// each list at most, so that steps do not wait for pages. The first call of a process also takes 18 steps
  /// of a small world of its own, so that they do not wait for code: no other world is touched.
  void reserve(std::size_t contacts);

  std::size_t body_count() const;
  bool is_kinematic(std::uint32_t body) const;
  const RigidBody& body(std::uint32_t body) const;
  const RigidBodyState& state(std::uint32_t body) const;
  /// @throws InputError: no such body, a state that is not finite.
  void set_state(std::uint32_t body, const RigidBodyState& state);
  Pose pose(std::uint32_t body) const;
  Vector3 velocity(std::uint32_t body) const;
  Vector3 angular_velocity(std::uint32_t body) const;
  std::span<const double> joint_values(std::uint32_t mechanism) const;
  std::span<const double> joint_rates(std::uint32_t mechanism) const;
  /// Mean torque of each joint's drive over the last step [N m] or [N].
  std::span<const double> joint_torques(std::uint32_t mechanism) const;
  Pose link_pose(std::uint32_t mechanism, std::uint32_t link) const;
  /// The velocity of the mover's point that is at p_W now [m/s].
  Vector3 velocity_at(const Mover& mover, const Vector3& p_W) const;
  Vector3 link_angular_velocity(std::uint32_t mechanism, std::uint32_t link) const;
  const Settings& settings() const;

  Vector3 linear_momentum() const;   ///< of free bodies and mechanisms [N s]
  Vector3 angular_momentum() const;  ///< the same, about the world's origin [N m s]
  double energy() const;             ///< kinetic and, in gravity, potential; the same [J]

  /// Moves everything by `h` [s] under gravity, drives and contact forces. First the impacts of touching
  /// points that approach (Newton's law; where steps are bounded, those alone that do by more than
  /// `contact_gap` in the step or faster than `bounce_speed`; drives of limited torque give instantaneous
  /// impacts no impulse), then forces that are constant over the step; where a point arrives, sliding ends or
  /// a joint gets to its rate within the step, the step is cut there. Velocities at the end obey the laws of
  /// ContactProblem; positions follow the mean of the velocities before and after, so constant forces are
  /// integrated exactly.
  /// Impulses act on both bodies at one point, about the mean of each one's path: total momentum stays to
  /// rounding.
  /// @param h positive and finite, or the step fails (StepFailure::bad_step).
  /// @param forces one a contact, or empty.
  StepReport step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace touchstone::physics
