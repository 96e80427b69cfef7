#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "physics/contact_solver.hpp"
#include "physics/mechanism_dynamics.hpp"
#include "physics/rigid_body.hpp"

// Bodies and mechanisms that push each other. Which narrowphase found the contact points is not known here.
//
// Threads: one thread owns a world; different worlds share nothing. Set-up throws InputError and changes
// nothing; step() neither throws nor, once as many contacts as reserved for have been seen, allocates.

namespace touchstone::physics {

/// One side of a contact.
struct Mover {
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
};

/// How a joint is driven. The torque of `rate` and `brake` is whatever the motion takes, up to the limit: it
/// is found together with the contact forces.
struct JointDrive {
  enum class Mode : std::uint8_t {
    torque,  ///< applies `torque`, cut to +-limit
    rate,    ///< follows `rate` with at most `limit`
    brake,   ///< holds with at most `limit`
  };
  Mode mode = Mode::torque;
  double torque = 0.0;                                     ///< [N m] or [N]
  double rate = 0.0;                                       ///< [rad/s] or [m/s]
  double limit = std::numeric_limits<double>::infinity();  ///< >= 0
};

/// What one contact did in a step.
struct ContactForce {
  Vector3 force_W;   ///< mean over the step, on B [N]; impacts included
  Vector3 impact_W;  ///< the impulse of impacts alone, on B [N s]
};

/// What contacts do to one body or link, about the world's origin.
struct Wrench {
  Vector3 force_W = Vector3::Zero();   ///< [N]
  Vector3 moment_W = Vector3::Zero();  ///< [N m]
};
/// Sum over the contacts of a step and what DynamicsWorld::step() wrote for them; each acts in the middle
/// between its points. @pre one force a contact.
Wrench wrench_on(const Mover& mover, std::span<const Contact> contacts, std::span<const ContactForce> forces);

enum class StepFailure : std::uint8_t {
  none,
  bad_contact,  ///< a contact that names nothing, a normal that is not unit, figures out of range
  body,         ///< a body's state would not be finite, or it would turn too far
  mechanism,    ///< the same of a mechanism
};
std::string_view to_string(StepFailure failure);

struct StepReport {
  StepFailure failure = StepFailure::none;  ///< if any, the state is as before the step
  std::uint32_t failed_index = 0;           ///< of the contact, body or mechanism
  double worst_residual = 0.0;              ///< of all solves [m/s]; see natural_residual()
  std::uint32_t solves = 0, unconverged = 0, sweeps = 0, newton_steps = 0;
  std::uint32_t substeps = 0;  ///< pieces the step was cut into: impacts and stops are located in time
  double last_stop = std::numeric_limits<double>::quiet_NaN();  ///< when within the step sliding or a braked
                                                                ///< joint last stopped [s]
};

class DynamicsWorld {
 public:
  struct Settings {
    Vector3 gravity_W = Vector3::Zero();  ///< [m/s2]
    double contact_gap = 1e-9;            ///< closer than this [m] (joint stops: rad or m) counts as touching
    double bounce_speed = 1e-3;           ///< approaches slower than this [m/s] do not bounce
    double push_out = 0.0;  ///< touching bodies deeper than the gap part at this rate times the depth [1/s]
    std::uint32_t most_substeps = 16;  ///< then contacts of the rest of the step are met without bouncing
    ContactSolver::Settings solver = {};
  };

  explicit DynamicsWorld(const Settings& settings);

  /// A free body. @throws InputError as RigidBody; a state that is not finite.
  std::uint32_t add_body(const RigidBody& body, const RigidBodyState& state);
  /// A body that moves as told, as if of infinite mass. @throws InputError for a bad pose.
  std::uint32_t add_kinematic(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W);
  /// Keeps a reference. All joints are free (torque 0) within their limits.
  /// @throws InputError: another number of values, values out of the joints' limits or not finite.
  std::uint32_t add_mechanism(const MechanismDynamics& dynamics, const Pose& X_WBase,
                              std::span<const double> q, std::span<const double> qd);
  /// A commanded rate is cut to the joint's own limit.
  /// @throws InputError: an unknown mechanism or joint value, a limit below 0, figures that are not finite.
  void set_drive(std::uint32_t mechanism, std::uint32_t value, const JointDrive& drive);
  /// Velocities of a kinematic body from now on. @throws InputError: not one.
  void set_velocity(std::uint32_t kinematic, const Vector3& v_W, const Vector3& w_W);
  /// Memory for `contacts` at a time, all joint rows besides.
  void reserve(std::size_t contacts);

  std::size_t body_count() const { return bodies_.size(); }
  bool is_kinematic(std::uint32_t body) const { return bodies_[body].is_kinematic; }
  const RigidBody& body(std::uint32_t body) const { return bodies_[body].body; }
  const RigidBodyState& state(std::uint32_t body) const { return bodies_[body].state; }
  void set_state(std::uint32_t body, const RigidBodyState& state) { bodies_[body].state = state; }
  Pose pose(std::uint32_t body) const { return bodies_[body].body.pose(bodies_[body].state); }
  Vector3 velocity(std::uint32_t body) const;
  Vector3 angular_velocity(std::uint32_t body) const;
  std::span<const double> joint_values(std::uint32_t mechanism) const { return mechanisms_[mechanism].q; }
  std::span<const double> joint_rates(std::uint32_t mechanism) const { return mechanisms_[mechanism].qd; }
  /// Mean torque of each joint's drive over the last step [N m] or [N].
  std::span<const double> joint_torques(std::uint32_t mechanism) const {
    return mechanisms_[mechanism].torque;
  }
  Pose link_pose(std::uint32_t mechanism, std::uint32_t link) const;

  Vector3 linear_momentum() const;   ///< of free bodies and mechanisms [N s]
  Vector3 angular_momentum() const;  ///< the same, about the world's origin [N m s]
  double energy() const;             ///< kinetic and, in gravity, potential; the same [J]

  /// Moves everything by `h` [s] under gravity, drives and contact forces. First the impacts of touching
  /// points that approach (Newton's law; drives of limited torque give no impulse in no time), then forces
  /// that are constant over the step; where a point arrives, sliding ends or a joint gets to its rate within
  /// the step, the step is cut there. Velocities at the end obey the laws of ContactProblem; positions follow
  /// the mean of the velocities before and after, so constant forces are integrated exactly. Impulses act on
  /// both bodies at one point, about the mean of each one's path: total momentum stays to rounding.
  /// @param forces one a contact, or empty.
  StepReport step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces = {});

 private:
  struct Body {
    RigidBody body;
    RigidBodyState state;
    bool is_kinematic = false;
    Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();  // kinematic
    RigidBodyState kept = {}, start = {},
                   flown = {};  // before the step, before its piece, after without impulses
    // Of the rows being gathered: velocities before impulses, and what impulses turn.
    Vector3 row_v_W = Vector3::Zero(), row_w_W = Vector3::Zero();
    Matrix3 row_inverse_W = Matrix3::Zero();
    Vector3 impulse_W = Vector3::Zero(), moment_W = Vector3::Zero();  // the moment about the world's origin
  };
  struct Arm {
    const MechanismDynamics* dynamics;
    Pose X_WBase;
    std::vector<double> q, qd, torque, start_torque, last_torque, tau, change, M;
    std::vector<double> kept_q, kept_qd, start_q, start_qd, flown_q, flown_qd;  // as Body's states
    std::vector<JointDrive> drives;
    MechanismDynamics::Workspace placed, scratch;
  };
  /// A contact on its way through the step.
  struct Point {
    Contact contact;
    Vector3 p_A, p_B;  // in the movers' frames
    Vector3 p_W;       // between the points, at the start of the piece
    Vector3 act_W;     // where impulses act
    Vector3 t1_W, t2_W;
    double separation, start_separation, start_speed;
    Vector3 impulse_W, start_impulse_W, impact_W, last_force_W;  // on B
    bool is_new;  // in the last step it had another name, or was not
  };
  struct Side {
    Mover mover;
    std::size_t first, size;  // of its row in J_ and Y_
  };
  struct Row {
    Side sides[2];
    int count;
  };
  /// A row of a joint: its drive, or an end stop.
  struct JointRow {
    std::uint32_t mechanism, value;
    double sign;
    bool is_stop;
  };
  /// Contacts and joint rows that have to do with each other: a run of block_order_, contacts first.
  struct Island {
    std::size_t first_block, contacts, joints;
  };
  static constexpr std::size_t kNoIsland = static_cast<std::size_t>(-1);
  enum class Phase { impact, forces };

  bool check(std::span<const Contact> contacts, StepReport& report) const;
  bool is_known(const Mover& mover) const;
  void attach(std::span<const Contact> contacts);
  void refresh();
  Pose mover_pose(const Mover& mover) const;
  Vector3 point_velocity(const Mover& mover, const Vector3& p_W) const;
  Vector3 relative_velocity(const Point& point) const;
  bool take_by_key(Point& point, std::size_t& next);
  void take_nearest(Point& point, std::size_t& next);

  void factor_masses();
  bool needs_impact() const;
  void impact(double h, StepReport& report);
  double piece(double left, double h, bool all, StepReport& report);
  bool fly(double t, StepReport& report);
  double first_stop(double t, bool& stops) const;
  double first_arrival(double t) const;
  void commit(double t, double h);
  void go_back();
  void finish(double h, std::span<ContactForce> forces);

  void gather(Phase phase, double t, bool all);
  void add_contact_rows(std::size_t index, Phase phase, double t);
  void add_joint_rows(std::uint32_t mechanism, Phase phase, double t, bool all);
  void add_joint_row(const JointRow& row, double b, ContactProblem::Bounds bounds, double warm);
  void add_side(Row& row, const Mover& mover, const Point& point, const Vector3& direction_W, double sign,
                Phase phase);
  double velocity_of(const Row& row, Phase phase) const;
  std::size_t first_row(std::size_t block) const {
    return block < active_.size() ? 3 * block : 2 * active_.size() + block;
  }
  std::size_t unit_of(const Mover& mover) const;
  std::size_t leader_of(std::size_t unit);
  void find_islands();
  void load_rows(const Island& island);
  void load_couplings();
  double velocities_from_impulses();
  double coupling(const Row& r, const Row& s) const;
  bool meet(const Row& r, const Row& s) const;
  void solve(StepReport& report);
  void accumulate();

  Settings settings_;
  ContactSolver solver_;
  std::vector<Body> bodies_;
  std::vector<Arm> mechanisms_;
  std::vector<Point> points_;
  std::vector<std::size_t> active_;  // points with rows, in order
  std::vector<JointRow> joint_rows_;
  std::vector<Row> rows_;
  std::vector<double> J_, Y_, b_, x_, u_, friction_;  // of all rows
  std::vector<ContactProblem::Bounds> bounds_;
  // Blocks are contacts, then joint rows.
  std::vector<std::size_t> leader_, island_of_unit_, island_of_block_, block_order_;
  std::vector<Island> islands_;
  // Of the island being solved.
  std::vector<std::size_t> local_rows_;
  std::vector<double> spread_;              // change of each unit's velocities
  std::vector<std::size_t> first_of_unit_;  // in spread_
  std::vector<double> W_, local_b_, local_x_, local_u_, local_friction_;
  std::vector<ContactProblem::Bounds> local_bounds_;
  struct Warm {
    std::uint64_t key;
    Mover a, b;
    Vector3 p_A;  // in A's frame
    Vector3 force_W;
    bool is_taken;
  };
  std::vector<Warm> warm_;
};

}  // namespace touchstone::physics
