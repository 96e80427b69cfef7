#include "touchstone/physics/world/rows/contact_rows.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/cholesky.hpp"
#include "touchstone/physics/solver/implicit_share.hpp"
#include "touchstone/physics/solver/reserved.hpp"
#include "touchstone/physics/world/groups/sleep.hpp"
#include "touchstone/physics/world/rows/held_joints.hpp"

namespace touchstone::physics::stepping {
namespace {

// A step's work for a point that is flown to, and whose rows are gathered.
constexpr double kPointWork = 500.0;
// Of the radius of gyration of what a joint moves: contacts with a shorter lever about its axis do not turn
// it. Such levers are rounding, or less than places of contact points are known to; what is driven against
// the axis would turn the joint by the inverse of it.
constexpr double kLeastLever = 0x1p-28;

/// A spring and a damper: see Gathering::make_linear().
struct LinearForce {
  double stiffness, damping;
  double error, rate;  // at the piece's start
  double wanted_rate;
};

/// A joint that moves: of a mechanism, or between movers.
struct Axis {
  ContactRows::Joint row;  // what all its rows have in common
  const JointDrive& drive;
  const JointLosses& losses;
  double lower, upper;
  double value;                       // at the start of the piece
  double rate, end_rate;              // there, and after its flight
  double commanded;                   // rate of what moves as commanded alone
  std::array<double, kTorques> last;  // by Torque
};

/// Writes the rows of one group for one phase.
class Gathering {
 public:
  /// @param is_pressed something that moves as commanded touches the group
  Gathering(const RowsWanted& wanted, bool is_pressed, const StepContext& step, Movers& movers,
            ContactRows& rows)
      : wanted_(wanted),
        settings_(step.settings),
        movers_(movers),
        rows_(rows),
        // What is commanded gives energy of its own, and stops what turns within a step. Bodies deep in each
        // other get the share of impulses that gives none (IslandSolver::limit_energy).
        holds_at_end_(wanted.phase == Phase::forces && !is_pressed && !step.is_soft) {}

  void prepare_units(const Group& group);
  void add_contact(std::size_t index, const GroupPoint& point);
  void add_joints(std::uint32_t mechanism);
  void add_held(std::uint32_t joint);

 private:
  Vector3 to_end(const Vector3& gained_W) const;
  Vector3 to_end(const GroupPoint& point, const Body& body) const;
  Vector3 add_side(const Mover& mover, const GroupPoint& point, const Vector3& act_W,
                   const ContactRows::Contact& contact, ContactRows::Side& side, double* b);
  std::size_t add_joint(const ContactRows::Joint& joint, double b, double commanded,
                        ContactProblem::Bounds bounds, double warm);
  void write_held(ContactRows::Joint& row);
  void write_part(const ContactRows::Joint& row, int part, const Vector3& force, const Vector3& moment);
  void make_linear(std::size_t index, const LinearForce& force);
  void add_axis(const Axis& axis);
  void add_drive(const Axis& axis);
  void add_losses(const Axis& axis);

  const RowsWanted& wanted_;
  const DynamicsWorld::Settings& settings_;
  Movers& movers_;
  ContactRows& rows_;
  const bool holds_at_end_;  // see to_end()
  std::size_t next_contact_ = 0, next_joint_ = 0;
  Vector3 act_W_ = Vector3::Zero();  // where the joint between movers that is being added acts
};

/// Velocities before impulses, at the start of an impact or after free flight. Forces act over the piece:
/// about the middle of a body's path, and turn it as it stands at the end.
void Gathering::prepare_units(const Group& group) {
  rows_.units.resize(movers_.unit_count());
  rows_.first_mechanism = movers_.unit_of_arm(0);
  rows_.members.assign(group.bodies.begin(), group.bodies.end());
  // Bodies have a mass, an inertia, a centre for levers and velocities.
  for (const std::uint32_t i : group.bodies) {
    const Body& body = movers_.bodies[i];
    const RigidBodyState& state = wanted_.phase == Phase::forces ? body.flown : body.state;
    RowUnit& unit = rows_.units[i];
    unit.mass = body.body.inertia().mass;
    unit.M = {}, unit.change = {};
    unit.middle_W = 0.5 * (body.state.p_W + state.p_W);
    unit.v_W = body.body.velocity(state);
    unit.inverse_inertia_W = body.body.inverse_inertia_W(state);
    unit.w_W = rotate(unit.inverse_inertia_W, state.angular_W);
    unit.force_W = unit.mass * settings_.gravity_W + body.push_W;
    unit.push_moment_W = body.push_moment_W;
    unit.is_jointed = body.is_jointed;
    if (body.is_jointed && wanted_.phase == Phase::forces)
      unit.middle_W = state.p_W - (0.5 * wanted_.t) * unit.v_W;
    if (wanted_.phase == Phase::parting) unit.v_W = unit.w_W = Vector3::Zero();
  }
  // Mechanisms have a mass matrix.
  for (const std::uint32_t m : group.mechanisms) {
    const std::uint32_t unit = movers_.unit_of_arm(m);
    rows_.members.push_back(unit);
    rows_.units[unit].mass = 0.0;
    rows_.units[unit].M = movers_.arms[m].M;
    rows_.units[unit].change = movers_.arms[m].change;
  }
}

/// Impulses act where a point is in the middle of the piece, but the laws hold for velocities where it is at
/// the end: about its middle, what tips would part from what holds it by t w^2 R / 2, and be lifted by that
/// in each step. Returns what the body's point gains in velocity on the way, as it turns at the start.
Vector3 Gathering::to_end(const GroupPoint& point, const Body& body) const {
  if (!holds_at_end_) return Vector3::Zero();
  return to_end(cross(body.w_W, Vector3((0.5 * wanted_.t) * (point.path_v_W - body.v_W))));
}

/// What a point gains that it turns aside by less than the contact gap is left out: at rest it keeps its
/// bits.
Vector3 Gathering::to_end(const Vector3& gained_W) const {
  return norm(gained_W) * wanted_.t > settings_.contact_gap ? gained_W : Vector3(Vector3::Zero());
}

/// Takes the side up. Returns a body's velocity at the point; a mechanism's goes to b, by its rows.
Vector3 Gathering::add_side(const Mover& mover, const GroupPoint& point, const Vector3& act_W,
                            const ContactRows::Contact& contact, ContactRows::Side& side, double* b) {
  side.unit = movers_.unit_of(mover);
  // A side that no impulse moves has its velocity only.
  if (side.unit == kNoUnit)
    return mover.kind == Mover::Kind::body && wanted_.phase != Phase::parting
               ? movers_.point_velocity(mover, point.p_W)
               : Vector3(Vector3::Zero());
  // A body has a lever.
  if (movers_.is_body(side.unit)) {
    const RowUnit& unit = rows_.units[side.unit];
    side.lever_W = act_W - unit.middle_W;
    return unit.v_W + cross(unit.w_W, side.lever_W) + to_end(point, movers_.bodies[side.unit]);
  }
  // A mechanism has three rows J and Y = M^-1 J^T, which are kept until made anew.
  const Arm& arm = movers_.arm_of(side.unit);
  const std::vector<double>& rates = wanted_.phase == Phase::forces ? arm.flown_qd : arm.qd;
  const std::size_t n = rates.size();
  std::vector<double>&J_all = rows_.J, &Y_all = rows_.Y;
  if (wanted_.is_anew) {
    const Vector3 directions[3] = {contact.n_W, contact.t1_W, contact.t2_W};
    side.first = J_all.size();
    J_all.resize(J_all.size() + 3 * n);
    Y_all.resize(J_all.size());
    for (std::size_t r = 0; r < 3; ++r) {
      const std::span<double> J = std::span(J_all).subspan(side.first + r * n, n),
                              Y = std::span(Y_all).subspan(side.first + r * n, n);
      arm.dynamics->point_jacobian(mover.link, point.p_W, side.sign * directions[r], J, arm.placed);
      for (std::size_t k = 0; k < n; ++k)
        if (std::abs(J[k]) <= kLeastLever * arm.reach[k]) J[k] = 0.0;
      std::copy(J.begin(), J.end(), Y.begin());
      solve_cholesky(arm.M, Y);
    }
  }
  // The joint rates add to b.
  for (std::size_t r = 0; r < 3 && wanted_.phase != Phase::parting; ++r)
    for (std::size_t k = 0; k < n; ++k) b[r] += J_all[side.first + r * n + k] * rates[k];
  if (!holds_at_end_) return Vector3::Zero();
  // J is that of the start: an arm that presses as it slides would part by half of this in each step.
  return to_end(wanted_.t * arm.dynamics->bias_acceleration(mover.link, point.p_W, arm.placed));
}

void Gathering::add_contact(std::size_t index, const GroupPoint& point) {
  const Contact& given = *point.contact;
  // A row that is made anew gets the contact's frame.
  if (wanted_.is_anew) {
    ContactRows::Contact& added = rows_.contacts.emplace_back();
    added.point = index;
    added.n_W = given.n_AB_W, added.t1_W = point.t1_W, added.t2_W = point.t2_W;
    added.sides[0].sign = -1.0, added.sides[1].sign = 1.0;
  }
  ContactRows::Contact& contact = rows_.contacts[next_contact_++];
  // The point goes on as it moves at the start.
  Vector3 act_W = point.p_W;
  if (wanted_.phase == Phase::forces) act_W += (0.5 * wanted_.t) * point.path_v_W;
  // b is the relative velocity without impulses; the commanded part is kept as well.
  double b[3] = {0.0, 0.0, 0.0};
  const Vector3 v_A = add_side(given.a, point, act_W, contact, contact.sides[0], b);
  const Vector3 v_B = add_side(given.b, point, act_W, contact, contact.sides[1], b);
  const Vector3 v = v_B - v_A;
  const Vector3 none = Vector3::Zero();
  double commanded = dot(contact.n_W, Vector3((contact.sides[1].unit == kNoUnit ? v_B : none) -
                                              (contact.sides[0].unit == kNoUnit ? v_A : none)));
  const Vector3 directions[3] = {contact.n_W, contact.t1_W, contact.t2_W};
  for (int i = 0; i < 3; ++i) {
    b[i] += dot(directions[i], v);
    rows_.x.push_back(wanted_.phase == Phase::forces    ? wanted_.t * dot(directions[i], point.last_force_W)
                      : wanted_.phase == Phase::parting ? dot(directions[i], point.parting_W)
                                                        : 0.0);
  }
  // The normal's velocity may come as far as the phase allows.
  const double bounce =
      wanted_.phase == Phase::impact && b[0] < -settings_.bounce_speed ? 1.0 + given.restitution : 1.0;
  const double room = wanted_.phase == Phase::forces && point.separation > settings_.contact_gap
                          ? point.separation / wanted_.t
                          : 0.0;
  b[0] = wanted_.phase == Phase::parting ? (point.separation + point.allowed_depth) / wanted_.t
                                         : bounce * b[0] + room;
  commanded = bounce * commanded + room;
  contact.room = room;
  rows_.commanded.push_back(commanded);
  rows_.b.insert(rows_.b.end(), b, b + 3);
  rows_.friction.push_back(given.friction);
}

/// Adds the row, and returns its number; entries that depend on its W are still to be set.
std::size_t Gathering::add_joint(const ContactRows::Joint& joint, double b, double commanded,
                                 ContactProblem::Bounds bounds, double warm) {
  rows_.b.push_back(b);
  rows_.commanded.push_back(commanded);
  rows_.x.push_back(warm);
  rows_.bounds.push_back(bounds);
  const std::size_t index = next_joint_++;
  if (joint.unit == kNoUnit) {
    if (wanted_.is_anew) rows_.joints.push_back(joint);
    write_held(rows_.joints[index]);
    return index;
  }
  if (!wanted_.is_anew) return index;
  const Arm& arm = movers_.arm_of(joint.unit);
  const std::size_t n = arm.q.size(), first = rows_.J.size();
  ContactRows::Joint& row = rows_.joints.emplace_back(joint);
  row.count = 1, row.units[0] = joint.unit, row.first[0] = first;
  rows_.J.resize(first + n, 0.0);
  rows_.Y.resize(first + n, 0.0);
  rows_.J[first + joint.value] = rows_.Y[first + joint.value] = joint.sign;
  solve_cholesky(arm.M, std::span(rows_.Y).subspan(first, n));
  return index;
}

/// The row's parts, for the joint that is being added: they depend on the length of the piece.
void Gathering::write_held(ContactRows::Joint& row) {
  const HeldJoint& held = movers_.joints[row.value];
  const bool turns = held.joint.joint.kind == BodyJointKind::hinge;
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  if (row.is_axis) {
    (turns ? moment : force) = row.sign * held.placed.axis_W;
  } else {
    force = held.placed.rows[row.held].force_W;
    moment = held.placed.rows[row.held].moment_W;
  }
  if (wanted_.is_anew) {
    row.count = 0;
    for (const Mover* mover : {&held.joint.a, &held.joint.b}) {
      const std::uint32_t unit = movers_.unit_of(*mover);
      if (unit == kNoUnit || (row.count == 1 && row.units[0] == unit)) continue;
      row.units[row.count] = unit;
      row.first[row.count++] = rows_.J.size();
      rows_.J.resize(rows_.J.size() + rows_.units[unit].width());
      rows_.Y.resize(rows_.J.size());
    }
  }
  for (int part = 0; part < row.count; ++part) write_part(row, part, force, moment);
}

/// One unit's, of either side that it is.
void Gathering::write_part(const ContactRows::Joint& row, int part, const Vector3& force,
                           const Vector3& moment) {
  const HeldJoint& held = movers_.joints[row.value];
  const std::uint32_t unit = row.units[part];
  const std::size_t n = rows_.units[unit].width();
  const std::span<double> J = std::span(rows_.J).subspan(row.first[part], n),
                          Y = std::span(rows_.Y).subspan(row.first[part], n);
  // J sums the sides of the joint that are on this unit.
  std::fill(J.begin(), J.end(), 0.0);
  for (const double sign : {-1.0, 1.0}) {
    const Mover& mover = sign < 0.0 ? held.joint.a : held.joint.b;
    if (movers_.unit_of(mover) != unit) continue;
    if (movers_.is_body(unit)) {
      const Vector3 turn = sign * (cross(Vector3(act_W_ - rows_.units[unit].middle_W), force) + moment);
      for (int i = 0; i < 3; ++i) J[i] += sign * force[i], J[i + 3] += turn[i];
      continue;
    }
    Arm& arm = movers_.arm_of(unit);
    const MechanismDynamics::Workspace& at = wanted_.phase == Phase::forces ? arm.scratch : arm.placed;
    const auto add = [&] {
      for (std::size_t k = 0; k < n; ++k) J[k] += arm.turned[k];
    };
    if (force != Vector3::Zero())
      arm.dynamics->point_jacobian(mover.link, held.placed.at_W, sign * force, arm.turned, at), add();
    if (moment != Vector3::Zero())
      arm.dynamics->turn_jacobian(mover.link, sign * moment, arm.turned, at), add();
  }
  // Y = M^-1 J^T is solved with the unit's inertia.
  std::copy(J.begin(), J.end(), Y.begin());
  if (!movers_.is_body(unit)) return solve_cholesky(movers_.arm_of(unit).M, Y);
  const Vector3 w = rotate(rows_.units[unit].inverse_inertia_W, Vector3(Y[3], Y[4], Y[5]));
  for (int i = 0; i < 3; ++i) Y[i] /= rows_.units[unit].mass, Y[i + 3] = w[i];
}

/// A force -(stiffness e + damping r) over the piece as a row: r = (1 - end) r0 + end u of the rates at the
/// piece's start and end, e that of the error e0 and where r leads from there, e0 + end t r. Of slow springs
/// that is the mean of both ends, which keeps their energy; stiff ones settle. @param index of the row, b of
/// which is u without impulses.
void Gathering::make_linear(std::size_t index, const LinearForce& force) {
  ContactRows::Joint& row = rows_.joints[index];
  const double t = wanted_.t, w = rows_.own_entry(index);
  double& b = rows_.b[3 * rows_.contacts.size() + index];
  const double end = implicit_share(t * w * (force.damping + t * force.stiffness));
  const double by_u = t * end * (force.damping + t * end * force.stiffness);
  const double error = force.error + t * end * (1.0 - end) * force.rate;
  const double rate = (1.0 - end) * force.rate - force.wanted_rate;
  const double rest = t * (force.stiffness * error + force.damping * rate);
  row.compliance = 1.0 / by_u;
  b += rest / by_u;
}

void Gathering::add_drive(const Axis& axis) {
  const JointDrive& drive = axis.drive;
  const Phase phase = wanted_.phase;
  const double t = wanted_.t;
  using Mode = JointDrive::Mode;
  ContactRows::Joint row = axis.row;
  if (drive.mode == Mode::torque) {
    // Mechanisms have flown with it.
    if (axis.row.unit != kNoUnit || phase != Phase::forces || drive.torque == 0.0) return;
    const double impulse = t * std::min(std::max(drive.torque, -drive.limit), drive.limit);
    add_joint(row, axis.end_rate, axis.commanded, {impulse, impulse}, impulse);
    return;
  }
  // An instantaneous impact has an impulse of a drive only where its torque is unlimited.
  if (phase == Phase::impact && drive.limit < kInfinity) return;
  const bool parts = phase == Phase::parting;  // then drives hold
  const double rate = parts ? 0.0 : axis.end_rate, last = parts ? 0.0 : t * axis.last[0];
  // A drive to a position is a spring and a damper, up to its limit.
  if (drive.mode == Mode::position) {
    if (phase == Phase::impact || (drive.stiffness == 0.0 && drive.damping == 0.0)) return;
    const double most = parts || drive.limit == kInfinity ? kInfinity : drive.limit * t;
    const std::size_t index = add_joint(row, rate, axis.commanded, {-most, most}, last);
    if (!parts)
      make_linear(index,
                  {drive.stiffness, drive.damping, axis.value - drive.position, axis.rate, drive.rate});
    return;
  }
  const double target = drive.mode == Mode::rate && !parts ? drive.rate : 0.0;
  // A drive that holds at rest is one with friction.
  const double friction = target == 0.0 ? axis.losses.friction : 0.0;
  const double limit = drive.limit + friction;
  const double most = parts || limit == kInfinity ? kInfinity : limit * t;
  row.stops = most > 0.0 && most < kInfinity;
  row.share = friction > 0.0 && limit < kInfinity ? drive.limit / limit : 1.0;
  row.before = axis.rate - (drive.mode == Mode::rate ? drive.rate : 0.0);
  add_joint(row, rate - target, axis.commanded - target, {-most, most}, last);
}

/// Friction and damping, which act over time alone.
void Gathering::add_losses(const Axis& axis) {
  if (wanted_.phase != Phase::forces) return;
  const JointLosses& losses = axis.losses;
  const double t = wanted_.t;
  ContactRows::Joint row = axis.row;
  using Mode = JointDrive::Mode;
  const bool is_held =
      axis.drive.mode == Mode::brake || (axis.drive.mode == Mode::rate && axis.drive.rate == 0.0);
  if (losses.friction > 0.0 && !is_held) {
    row.torque = Torque::friction;
    row.stops = true;
    row.before = axis.rate;
    const double most = losses.friction * t;
    add_joint(row, axis.end_rate, axis.commanded, {-most, most}, t * axis.last[1]);
  }
  if (losses.damping > 0.0) {
    row.torque = Torque::damping;
    row.stops = false;
    const std::size_t index =
        add_joint(row, axis.end_rate, axis.commanded, {-kInfinity, kInfinity}, t * axis.last[2]);
    make_linear(index, {0.0, losses.damping, 0.0, axis.rate, 0.0});
  }
}

void Gathering::add_axis(const Axis& axis) {
  const double t = wanted_.t, rate = wanted_.phase == Phase::parting ? 0.0 : axis.end_rate;
  add_drive(axis);
  add_losses(axis);
  for (const double sign : {1.0, -1.0}) {
    const double limit = sign > 0.0 ? axis.lower : axis.upper;
    const double room = sign * (axis.value - limit);
    const bool is_open = !(room <= settings_.contact_gap);
    if (std::isinf(limit) || (is_open && !wanted_.all)) continue;
    ContactRows::Joint row = axis.row;
    row.sign = sign, row.is_stop = true;
    const double open = is_open ? room / t : 0.0;
    add_joint(row, sign * rate + open, sign * axis.commanded + open, {0.0, kInfinity}, 0.0);
  }
}

void Gathering::add_joints(std::uint32_t mechanism) {
  const Arm& arm = movers_.arms[mechanism];
  const bool is_flown = wanted_.phase == Phase::forces;
  const std::size_t n = arm.q.size();
  for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
    const std::uint32_t i = joint.value;
    if (i == Mechanism::kNone) continue;
    add_axis({{movers_.unit_of_arm(mechanism), i, 1.0, false},
              arm.drives[i],
              arm.losses[i],
              joint.lower,
              joint.upper,
              arm.q[i],
              arm.qd[i],
              is_flown ? arm.flown_qd[i] : arm.qd[i],
              0.0,
              {arm.last_torque[i], arm.last_torque[n + i], arm.last_torque[2 * n + i]}});
  }
}

/// Rows of a joint between movers: the held directions, then those along its axis. Its impulses act at one
/// point on both, where that was in the middle of the piece.
void Gathering::add_held(std::uint32_t index) {
  HeldJoint& held = movers_.joints[index];
  const bool is_flown = wanted_.phase == Phase::forces, parts = wanted_.phase == Phase::parting;
  const double t = wanted_.t;
  // The joint is placed by both sides' motions, as flown or as they are now.
  const auto motion = [&](const Mover& mover) {
    return is_flown ? motion_flown(mover, movers_, t) : motion_now(mover, movers_);
  };
  const FrameMotion a = motion(held.joint.a), b = motion(held.joint.b);
  held.placed = held.joint.joint.place(a, b);
  const Vector3 v_A = a.v_W + cross(a.w_W, Vector3(held.placed.at_W - a.X_WM.p)),
                v_B = b.v_W + cross(b.w_W, Vector3(held.placed.at_W - b.X_WM.p)), v = v_B - v_A,
                w = b.w_W - a.w_W;
  // Sides that no impulse moves give the commanded velocities.
  const auto commanded = [&](const Vector3& of_A, const Vector3& of_B) -> Vector3 {
    const Vector3 none = Vector3::Zero();
    return (movers_.unit_of(held.joint.b) == kNoUnit ? of_B : none) -
           (movers_.unit_of(held.joint.a) == kNoUnit ? of_A : none);
  };
  const Vector3 commanded_v = commanded(v_A, v_B), commanded_w = commanded(a.w_W, b.w_W);
  // Impulses act at the joint's point in the middle of the piece.
  act_W_ = held.placed.at_W;
  if (is_flown) act_W_ -= (0.25 * t) * (v_A + v_B);
  // Each held direction has a row without bounds.
  ContactRows::Joint row{kNoUnit, index, 1.0, false};
  row.is_axis = false;
  for (std::uint32_t i = 0; i < held.placed.count; ++i) {
    const BodyJointRow& direction = held.placed.rows[i];
    row.held = i;
    add_joint(row, parts ? 0.0 : dot(direction.force_W, v) + dot(direction.moment_W, w),
              dot(direction.force_W, commanded_v) + dot(direction.moment_W, commanded_w),
              {-kInfinity, kInfinity}, is_flown ? t * held.last[i] : 0.0);
  }
  // The free axis has limits, losses and a drive.
  if (!held.joint.joint.has_axis()) return;
  row.is_axis = true;
  const double* const last = &held.last[BodyJoint::kMostRows];
  add_axis(
      {row,
       held.joint.drive,
       held.joint.losses,
       held.joint.lower,
       held.joint.upper,
       held.value,
       held.rate,
       is_flown ? held.placed.rate : held.rate,
       dot(held.placed.axis_W, held.joint.joint.kind == BodyJointKind::hinge ? commanded_w : commanded_v),
       {last[0], last[1], last[2]}});
}

}  // namespace

void ContactRows::reserve(std::size_t most_contacts, std::size_t joint_rows, std::size_t most_units,
                          std::size_t widest) {
  const std::size_t rows = 3 * most_contacts + joint_rows;
  reserve_written(units, most_units);
  reserve_written(members, most_units);
  reserve_written(contacts, most_contacts);
  reserve_written(joints, joint_rows);
  reserve_written(bounds, joint_rows);
  reserve_written(friction, most_contacts);
  for (auto* vector : {&b, &x, &u, &commanded}) reserve_written(*vector, rows);
  for (auto* vector : {&J, &Y}) reserve_written(*vector, 2 * widest * rows);
}

std::uint32_t ContactRows::unit_of_block(std::size_t block) const {
  if (block >= contacts.size()) return joints[block - contacts.size()].units[0];
  const Side* const sides = contacts[block].sides;
  return sides[0].unit != kNoUnit ? sides[0].unit : sides[1].unit;
}

double ContactRows::own_entry(std::size_t joint) const {
  const Joint& row = joints[joint];
  double sum = 0.0;
  for (int part = 0; part < row.count; ++part) {
    const std::size_t first = row.first[part];
    for (std::size_t k = 0; k < units[row.units[part]].width(); ++k) sum += J[first + k] * Y[first + k];
  }
  return sum;
}

Vector3 ContactRows::impulse_of(std::size_t contact) const {
  const Contact& of = contacts[contact];
  const double* const impulse = &x[3 * contact];
  return (impulse[0] * of.n_W + impulse[1] * of.t1_W) + impulse[2] * of.t2_W;
}

void gather(const RowsWanted& wanted, const GroupState& group, StepContext& step, Movers& movers,
            ContactRows& rows) {
  if (wanted.is_anew) {
    rows.contacts.clear();
    rows.joints.clear();
    for (auto* vector : {&rows.J, &rows.Y}) vector->clear();
  }
  for (auto* vector : {&rows.b, &rows.commanded, &rows.x, &rows.friction}) vector->clear();
  rows.bounds.clear();
  rows.length = wanted.phase == Phase::forces ? wanted.t : 0.0;
  step.budget.spend(kPointWork * static_cast<double>(group.points.size()));
  const bool is_pressed = std::any_of(group.kinematics.begin(), group.kinematics.end(),
                                      [&](std::uint32_t i) { return moves(movers.bodies[i]); });
  Gathering gathering(wanted, is_pressed, step, movers, rows);
  gathering.prepare_units(group.members);
  for (std::size_t i = 0; i < group.points.size(); ++i)
    if (wanted.all || group.points[i].separation <= step.settings.contact_gap)
      gathering.add_contact(i, group.points[i]);
  for (const std::uint32_t m : group.members.mechanisms) gathering.add_joints(m);
  for (const std::uint32_t j : group.members.joints) gathering.add_held(j);
}

void factor_masses(const Group& group, Movers& movers) {
  for (const std::uint32_t m : group.mechanisms) {
    Arm& arm = movers.arms[m];
    arm.dynamics->mass_matrix(arm.M, arm.placed);
    const std::size_t n = arm.q.size();
    const std::span<const double> masses = arm.dynamics->moved_masses();
    for (std::size_t k = 0; k < n; ++k)
      arm.reach[k] = masses[k] > 0.0 ? std::sqrt(arm.M[k * n + k] / masses[k]) : 0.0;
    factor_cholesky(arm.M, arm.q.size());
  }
}

void sum_impulses(ContactRows& rows) {
  // The sums start at zero.
  for (const std::uint32_t member : rows.members) {
    RowUnit& unit = rows.units[member];
    unit.impulse_W = unit.moment_W = Vector3::Zero();
    std::fill(unit.change.begin(), unit.change.end(), 0.0);
  }
  // Contacts add impulses and moments to bodies, changes of rates to mechanisms.
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    const Vector3 impulse = rows.impulse_of(i);
    for (const ContactRows::Side& side : rows.contacts[i].sides) {
      if (side.unit == kNoUnit) continue;
      RowUnit& unit = rows.units[side.unit];
      if (unit.is_body()) {
        unit.impulse_W += side.sign * impulse;
        unit.moment_W += cross(side.lever_W, side.sign * impulse);
        continue;
      }
      const std::size_t n = unit.change.size();
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = 0; k < n; ++k)
          unit.change[k] += rows.Y[side.first + r * n + k] * rows.x[3 * i + r];
    }
  }
  // Joint rows add the same.
  for (std::size_t j = 0; j < rows.joints.size(); ++j) {
    const ContactRows::Joint& joint = rows.joints[j];
    const double x = rows.joint_impulse(j);
    for (int part = 0; part < joint.count; ++part) {
      RowUnit& unit = rows.units[joint.units[part]];
      const std::size_t first = joint.first[part];
      if (unit.is_body()) {
        unit.impulse_W += x * rows.vector_at(first);
        unit.moment_W += x * rows.vector_at(first + 3);
        continue;
      }
      for (std::size_t k = 0; k < unit.change.size(); ++k) unit.change[k] += rows.Y[first + k] * x;
    }
  }
}

}  // namespace touchstone::physics::stepping
