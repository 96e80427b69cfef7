#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "touchstone/physics/contact_solver.hpp"
#include "touchstone/physics/convex_contacts.hpp"
#include "touchstone/physics/mechanism_dynamics.hpp"
#include "touchstone/physics/rigid_body.hpp"

/// @file
/// Bodies and mechanisms that push each other. Which narrowphase found the contact points is not known here.
///
/// Threads: one thread owns a world; different worlds share nothing. Set-up throws InputError and changes
/// nothing; step() neither throws nor, once as many contacts as reserved for have been seen, allocates.

namespace touchstone::physics {

/// One side of a contact.
struct Mover {
  /// What it belongs to; the ground never moves.
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
  /// What `torque`, `rate` and `limit` mean.
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
/// What it says of the contact, body, mechanism or object that StepReport::failed_index names: "its state
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
  bool is_work_spent = false;       ///< the step went on with what was found when its work ended
  std::uint32_t substeps = 0;       ///< pieces the step was cut into: impacts and stops are located in time
  double last_stop = std::numeric_limits<double>::quiet_NaN();  ///< when within the step sliding or a braked
                                                                ///< joint last stopped [s]
};

/// Free and kinematic bodies and mechanisms under gravity, drives and contacts, stepped in time. Threads and
/// errors: see dynamics_world.hpp. A copy is a snapshot: assigned back, and given contacts found anew, it
/// takes the same steps to the bit (but for links' inertias, which are MechanismDynamics' own).
class DynamicsWorld {
 public:
  /// How hard contact problems are tried.
  enum class Accuracy : std::uint8_t {
    bounded,  ///< as long as the step's work lasts; groups of more than 21 points in one piece
    exact,    ///< by every means of ContactSolver, however long that takes
  };

  /// The same for every step. Figures that are not finite, a gap or tolerance that is not > 0, speeds, rates
  /// or counts below 0, and no pieces, rounds or island sweeps are an InputError.
  struct Settings {
    Vector3 gravity_W = Vector3::Zero();  ///< [m/s2]
    double contact_gap = 1e-9;            ///< closer than this [m] (joint stops: rad or m) counts as touching
    double bounce_speed = 1e-3;           ///< approaches slower than this [m/s] do not bounce
    /// What is deeper than 100 000 gaps (0.1 mm) parts at this rate times its depth [1/s], at 1 mm/s at least
    /// (0: not at all), but no faster than `part_speed` [m/s]: it is moved, and gets no momentum by it.
    /// Deeper overlap that a step makes anew goes at its end.
    double push_out = 5.0, part_speed = 0.05;
    /// What hangs together by contacts and has moved slower than `sleep_speed` [m/s] for `sleep_time` [s]
    /// sleeps: it has no momentum, and is not looked at until something awake comes near or it is told to
    /// move. Infinite: nothing sleeps. A body's speed is its centre's and, for its turning, |w| sqrt(tr I /
    /// m).
    double sleep_speed = 1e-3, sleep_time = std::numeric_limits<double>::infinity();
    std::uint32_t most_substeps = 16;  ///< then contacts of the rest of the step are met without bouncing
    ContactSolver::Settings solver = {};
    Accuracy accuracy = Accuracy::bounded;
    /// What a step of Accuracy::bounded may take before it goes on with the best found so far, which is said:
    /// this many thousand multiplications for each contact given, as for four contacts for each joint, and as
    /// for 12 at least; as many again for parting what overlaps. A thousand take some 0.5 us.
    double work = 12.0;
    /// The same by the clock [us], for live use: results then depend on the machine. Infinite: not looked at.
    double most_microseconds = std::numeric_limits<double>::infinity();
  };

  explicit DynamicsWorld(const Settings& settings);

  /// A free body. @throws InputError as RigidBody; a state that is not finite.
  std::uint32_t add_body(const RigidBody& body, const RigidBodyState& state);
  /// A body that moves as told, as if of infinite mass. @throws InputError for a bad pose, velocities that
  /// are not finite.
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
  /// A free body as it is from now on, after a latch or a release, say; also of one that was held out.
  /// @throws InputError: no such body, a state that is not finite. Does not allocate.
  void set_body(std::uint32_t body, const RigidBody& as, const RigidBodyState& state);
  /// Out of the world until set_body(): it stays where it is, and has no momentum. @pre no contact names it.
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
  /// Ends a free body's sleep, and that of all it lies with.
  void wake(std::uint32_t body);
  bool is_asleep(std::uint32_t body) const { return bodies_[body].is_asleep; }
  /// The first of those that it lies with. @pre it is asleep
  std::uint32_t first_of_sleepers(std::uint32_t body) const { return bodies_[body].first_sleeper; }
  std::uint32_t sleepers() const { return sleepers_; }  ///< bodies
  /// Whether every free body sleeps, nothing else moves, and there are no mechanisms.
  bool is_at_rest() const { return restless_ == 0 && mechanisms_.empty(); }
  /// Whether what touches it is to be looked at: not ground, sleepers, and kinematic bodies that stand.
  bool is_restless(const Mover& mover) const;
  /// Memory for `contacts` at a time, all joint rows besides.
  void reserve(std::size_t contacts);

  std::size_t body_count() const { return bodies_.size(); }
  bool is_kinematic(std::uint32_t body) const { return bodies_[body].is_kinematic; }
  const RigidBody& body(std::uint32_t body) const { return bodies_[body].body; }
  const RigidBodyState& state(std::uint32_t body) const { return bodies_[body].state; }
  /// @throws InputError: no such body, a state that is not finite.
  void set_state(std::uint32_t body, const RigidBodyState& state);
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
  /// Of the mover's point now at p_W [m/s].
  Vector3 velocity_at(const Mover& mover, const Vector3& p_W) const;
  Vector3 link_angular_velocity(std::uint32_t mechanism, std::uint32_t link) const;
  const Settings& settings() const { return settings_; }

  Vector3 linear_momentum() const;   ///< of free bodies and mechanisms [N s]
  Vector3 angular_momentum() const;  ///< the same, about the world's origin [N m s]
  double energy() const;             ///< kinetic and, in gravity, potential; the same [J]

  /// Moves everything by `h` [s] under gravity, drives and contact forces. First the impacts of touching
  /// points that approach (Newton's law; drives of limited torque give no impulse in no time), then forces
  /// that are constant over the step; where a point arrives, sliding ends or a joint gets to its rate within
  /// the step, the step is cut there. Velocities at the end obey the laws of ContactProblem; positions follow
  /// the mean of the velocities before and after, so constant forces are integrated exactly. Impulses act on
  /// both bodies at one point, about the mean of each one's path: total momentum stays to rounding.
  /// @param h positive and finite, or the step fails (StepFailure::bad_step).
  /// @param forces one a contact, or empty.
  StepReport step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces = {});

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Body {
    RigidBody body;
    RigidBodyState state;
    bool is_kinematic = false, is_met = false, is_asleep = false;
    std::uint32_t first_sleeper = 0, next_sleeper = 0;                  // a ring of those that sleep together
    double still_for = 0.0;                                             // [s]
    Vector3 told_v_W = Vector3::Zero(), told_w_W = Vector3::Zero();     // kinematic
    Vector3 push_W = Vector3::Zero(), push_moment_W = Vector3::Zero();  // about its centre
    RigidBodyState kept = {}, start = {},
                   flown = {};  // before the step, before its piece, after without impulses
    // Of the state.
    Pose X_WB = {};
    Vector3 v_W = Vector3::Zero(), w_W = Vector3::Zero();
    // Of the rows being gathered: the middle of its way, velocities before impulses, what impulses turn.
    Vector3 middle_W = Vector3::Zero(), row_v_W = Vector3::Zero(), row_w_W = Vector3::Zero();
    Matrix3 row_inverse_W = Matrix3::Zero();
    Vector3 change_v_W = Vector3::Zero(), change_w_W = Vector3::Zero();  // by the rows' impulses
    Vector3 impulse_W = Vector3::Zero(), moment_W = Vector3::Zero();     // the moment about its middle
  };
  struct Arm {
    const MechanismDynamics* dynamics;
    Pose X_WBase;
    std::vector<double> q, qd, torque, start_torque, last_torque, tau, change, M;
    std::vector<double> kept_q, kept_qd, start_q, start_qd, flown_q, flown_qd;  // as Body's states
    std::vector<double> kept_torque, kept_last_torque;
    std::vector<double> push, turned;  // torques; scratch
    std::vector<JointDrive> drives;
    MechanismDynamics::Workspace placed, scratch;
  };
  /// A mover at a point.
  struct Side {
    std::uint32_t unit;  // kNone: nothing moves it but what it was told
    double sign;
    Vector3 lever_W;    // a body's: from the middle of its way to where impulses act
    std::size_t first;  // a mechanism's: of its three rows in J_ and Y_
  };
  /// A contact on its way through the step.
  struct Point {
    const Contact* contact;
    std::uint32_t index;  // of the contact
    Side sides[2];
    Vector3 p_A, p_B;               // in the movers' frames
    Vector3 p_W;                    // between the points, at the start of the piece
    Vector3 v_W;                    // of B's point seen from A's, there
    Vector3 mean_v_W;               // of both
    Vector3 act_W;                  // where impulses act
    Vector3 t1_W, t2_W;             // at right angles to the normal
    double separation, approach_v;  // at the start of the piece; the speed after its impact
    double first_depth;             // at the start of the step
    Vector3 impulse_W, start_impulse_W, impact_W, last_force_W;  // on B
  };
  /// A row of a joint: its drive, or an end stop.
  struct JointRow {
    std::uint32_t mechanism, value;
    double sign;
    bool is_stop;
    std::size_t first;  // of its row in Y_
  };
  /// A row of the island being solved, written out: velocities of its units are J_, what it does to them Y_.
  using Row = SparseContacts::Row;
  /// What contacts join, touching or near, directly or through others: it goes through the step by a clock of
  /// its own, and nothing of it is seen by the rest.
  struct Group {
    std::span<const std::uint32_t> contacts, bodies, mechanisms;
  };
  /// Contacts and joint rows of a group that have to do with each other: a run of block_order_, contacts
  /// first; and the units they move.
  struct Island {
    std::size_t first_block, contacts, joints, first_unit, units;
  };
  /// What a contact of the last step leaves to the next.
  struct Warm {
    std::uint64_t key = 0;
    Mover a = {}, b = {};
    Vector3 p_A = Vector3::Zero();  // in A's frame
    Vector3 force_W = Vector3::Zero();
    bool is_taken = false;
  };
  struct Carried {
    Vector3 force_W;
    Vector3 p_A;  // in A's frame, where its pair's forces are passed on
  };
  enum class Phase { impact, forces, parting };
  /// How far a group is in the step.
  struct Clock {
    double left;
    std::uint32_t pieces = 0;
    double probe =
        std::numeric_limits<double>::infinity();  // the last piece, if something stopped at its end
  };
  /// The first stop within a piece.
  struct Stop {
    bool is_any = false;
    double when = 0.0;
    double speed = 0.0;   // the largest at the start of what stops [m/s], [rad/s]
    double missed = 0.0;  // the farthest that something is off at the end, as it stopped before [m], [rad]
  };
  struct StopSearch {
    int tries = 0;          // left
    bool is_probe = false;  // so short a piece that it tells how velocities go on
    bool is_aimed = false;  // a stop should be at its end
  };

  // dynamics_world.cpp
  std::uint32_t unit_of(const Mover& mover) const;  // kNone: the ground, a kinematic body
  bool is_body(std::uint32_t unit) const { return unit < bodies_.size(); }
  Arm& arm_of(std::uint32_t unit) { return mechanisms_[unit - bodies_.size()]; }
  const Arm& arm_of(std::uint32_t unit) const { return mechanisms_[unit - bodies_.size()]; }

  // dynamics_points.cpp
  bool check(std::span<const Contact> contacts, StepReport& report) const;
  bool is_known(const Mover& mover) const;
  void carry_forces(std::span<const Contact> contacts);
  void take_by_key(const Contact& contact, Carried& carried, std::size_t& next);
  void pass_on(std::span<const Contact> contacts, std::span<Carried> carried, std::size_t& next);
  void attach(std::span<const Contact> contacts);
  void refresh();
  void update_speeds();
  double separation_now(const Point& point) const;
  Pose mover_pose(const Mover& mover) const;
  Vector3 point_velocity(const Mover& mover, const Vector3& p_W) const;

  // dynamics_groups.cpp
  std::uint32_t leader_of(std::uint32_t unit);
  void join(std::uint32_t a, std::uint32_t b);
  void find_groups(std::span<const Contact> contacts);
  void sort_by_group(std::span<const Contact> contacts, std::uint32_t groups);

  // dynamics_step.cpp
  bool step_group(double h, std::span<const Contact> contacts, StepReport& report);
  bool step_loose(double h, StepReport& report);
  double piece(Clock& clock, double h, bool all, StepReport& report);
  WorkBudget budget_of(std::size_t contacts) const;
  bool is_work_over(const StepReport& report) const;
  void keep_start();
  void keep();
  void undo();
  void go_back();
  static bool fail(StepFailure failure, std::size_t index, StepReport& report);
  bool is_group_finite(StepReport& report) const;
  void finish(double h);

  // dynamics_impacts.cpp
  bool needs_impact() const;
  void impact(double h, StepReport& report);

  // dynamics_flight.cpp
  void update_motions();
  void place_kinematics(double elapsed);
  bool begin_flight(StepReport& report);
  bool fly(double t, StepReport& report);
  bool fly_body(const Body& body, RigidBodyState& state, double t) const;
  void forget_pushes();
  static bool fail_flight(const Body& body, double t, std::uint32_t index, StepReport& report);
  void accumulate();
  void commit(double t, double h);

  // dynamics_parting.cpp
  double allowed_depth(const Point& point) const;
  bool needs_parting() const;
  void part(double h, StepReport& report);
  void move_apart(double h);
  bool is_free_group() const;

  // dynamics_sleep.cpp
  void wake_touched(std::span<const Contact> contacts);
  void count_stillness(double h);
  bool is_still(std::uint32_t body) const;
  void put_to_sleep();
  void wake_all();
  static bool moves(const Body& body);
  void count_restless();

  // dynamics_events.cpp
  bool has_brakes() const;
  Stop first_stop(double t) const;
  Stop coming_stop(double t, double left) const;
  bool can_stop(std::size_t joint_row) const;
  double rate_before(const JointRow& row) const;
  bool seek_stop(const Stop& stop, double left, double& t, StopSearch& search) const;
  double first_arrival(double t) const;

  // dynamics_rows.cpp
  void factor_masses();
  void gather(Phase phase, double t, bool all, bool anew);
  void prepare_bodies(Phase phase);
  void add_contact(std::size_t index, Phase phase, double t);
  Vector3 add_side(Side& side, const Mover& mover, const Point& point, Phase phase, double* b);
  void add_joint_rows(std::uint32_t mechanism, Phase phase, double t, bool all);
  void add_joint_row(const JointRow& row, double b, ContactProblem::Bounds bounds, double warm);
  Vector3 impulse_of(std::size_t contact) const;
  std::size_t first_row(std::size_t block) const {
    return block < active_.size() ? 3 * block : 2 * active_.size() + block;
  }

  // dynamics_islands.cpp
  void find_islands();
  std::uint32_t unit_of_block(std::size_t block) const;
  void solve(StepReport& report);
  void solve_island(const Island& island, StepReport& report);
  void fail_solve(const Island& island, StepReport& report) const;
  struct Residual {
    double worst;   // the natural residual or a little more
    bool is_still;  // to rounding, or almost
  };
  Residual update_velocities(const Island& island);
  bool may_refine(const Island& island);
  void refine(const Island& island);
  void spread_impulses(const Island& island);
  double contact_velocities(std::size_t block, double& scale);
  double joint_velocity(std::size_t block, double& scale);
  SolveReport solve_loaded(const Island& island, WorkBudget* budget);
  void load_island(const Island& island);
  void write_out(std::size_t block, std::size_t i);
  void load_couplings();
  SolveReport solve_afresh(const Island& island, double warm, StepReport& report);
  double coupling(const Row& r, const Row& s) const;
  static bool meet(const Row& r, const Row& s);

  // dynamics_convex.cpp
  std::size_t width_of(std::uint32_t unit) const { return is_body(unit) ? 6 : arm_of(unit).q.size(); }
  double tolerance_of(const Island& island, bool is_exact) const;
  bool is_contradicted(const Island& island) const;
  void load_convex(const Island& island);
  SolveReport solve_convex(const Island& island, StepReport& report);

  Settings settings_;
  ContactSolver solver_;
  std::vector<Body> bodies_;
  std::vector<Arm> mechanisms_;
  std::vector<Warm> warm_, next_warm_;  // by contact
  std::vector<Carried> carried_;        // by contact
  std::vector<ContactForce> forces_;    // by contact, of the step on its way
  // Units are bodies, then mechanisms.
  std::vector<std::uint32_t> leader_, group_of_unit_, island_of_unit_;
  std::vector<std::uint32_t> contact_order_, body_order_, mechanism_order_, loose_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> group_of_contact_, fill_;
  // Of the group on its way.
  Group group_;
  std::vector<std::uint32_t> kinematics_;
  std::vector<Point> points_;
  std::vector<std::size_t> active_;  // points with rows, in order
  std::vector<JointRow> joint_rows_;
  std::vector<double> J_, Y_;  // rows of mechanisms, then those written out
  bool has_rows_ = false;      // those being gathered
  std::vector<double> b_, x_, u_, friction_;
  std::vector<ContactProblem::Bounds> bounds_;
  // Blocks are contacts, then joint rows.
  std::vector<std::size_t> block_order_;
  std::vector<std::uint32_t> island_of_block_, unit_order_;
  std::vector<Island> islands_;
  std::vector<double> residuals_, scales_;   // by block of the island
  std::vector<std::uint8_t> patience_;       // by unit: steps until its rest may be refined again
  std::vector<std::uint8_t> kept_patience_;  // before the step
  // Of the island being solved.
  std::vector<Row> rows_;
  std::vector<std::size_t> local_rows_;
  std::vector<double> W_, local_b_, local_x_, warm_x_, local_friction_;
  std::vector<ContactProblem::Bounds> local_bounds_;
  bool is_pushed_ = false;                     // something is
  double h_ = 0.0;                             // the whole step
  bool is_coarse_ = false;                     // the group goes through the step in one piece
  std::uint32_t restless_ = 0, sleepers_ = 0;  // free bodies awake and kinematic ones that move; asleep
  // By unit: how often its island, whose contacts contradicted each other, is still taken to do so.
  std::vector<std::uint8_t> contradicted_, kept_contradicted_;
  WorkBudget budget_;  // of the step
  ConvexContacts convex_;
  std::vector<std::uint32_t> convex_sizes_, local_unit_;  // by the island's unit; by unit
  std::vector<double> masses_;                            // of the island's units
  std::vector<Row> convex_rows_;                          // units as the island counts them
};

}  // namespace touchstone::physics
