#include "touchstone/physics/dynamics_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics {
namespace {

RigidBody unit_body() { return {box_inertia(1.0, {1, 1, 1}), "unit"}; }

std::string indexed(const char* what, std::size_t index) { return what + (" " + std::to_string(index)); }

bool is_at_least_0(double value) { return value >= 0.0 && std::isfinite(value); }
bool is_above_0(double value) { return value > 0.0 && std::isfinite(value); }

void validate(const DynamicsWorld::Settings& settings) {
  if (!touchstone::is_finite(settings.gravity_W)) throw InputError("dynamics: gravity is not finite");
  if (!is_above_0(settings.contact_gap) || !is_at_least_0(settings.bounce_speed) ||
      !is_at_least_0(settings.push_out) || !is_at_least_0(settings.part_speed))
    throw InputError(
        "dynamics: the contact gap must be > 0, bounce speed, push-out and part speed >= 0, all finite");
  if (!is_at_least_0(settings.sleep_speed) || !(settings.sleep_time >= 0.0))
    throw InputError("dynamics: the speed and time of falling asleep must be >= 0");
  if (settings.most_substeps == 0) throw InputError("dynamics: a step has at least one piece");
  const ContactSolver::Settings& solver = settings.solver;
  if (!is_above_0(solver.tolerance))
    throw InputError("dynamics: the solver's tolerance must be > 0 and finite");
  if (solver.rounds < 1 || solver.sweeps < 0 || solver.newton_steps < 0)
    throw InputError("dynamics: the solver takes at least one round, sweeps and Newton steps >= 0");
  if (!(settings.work >= 0.0) || !(settings.most_microseconds >= 0.0))
    throw InputError("dynamics: a step's work and time must be >= 0");
}

}  // namespace

std::string_view to_string(StepFailure failure) {
  constexpr std::array<std::string_view, 7> kNames{"none", "bad_step",  "bad_contact", "body",
                                                   "turn", "mechanism", "latch"};
  return kNames[static_cast<std::size_t>(failure)];
}

std::string_view reason_of(StepFailure failure) {
  switch (failure) {
    case StepFailure::none:
      return "";
    case StepFailure::bad_step:
      return "the step's length is not positive and finite";
    case StepFailure::bad_contact:
      return "a contact of theirs is none: points that are not finite, a normal that is not unit, friction "
             "or "
             "restitution out of range";
    case StepFailure::body:
      return "its state would not be finite";
    case StepFailure::turn:
      return "it would turn by more than 64 rad in a step";
    case StepFailure::mechanism:
      return "its joint values or rates would not be finite, or a joint moves no inertia";
    case StepFailure::latch:
      return "latched or let go, a body would have an inertia that is none to rounding";
  }
  return "";
}
static_assert(RigidBody::kMostTurn == 64.0, "as reason_of() says");

Wrench wrench_on(const Mover& mover, std::span<const Contact> contacts,
                 std::span<const ContactForce> forces) {
  Wrench out;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const double sign : {-1.0, 1.0}) {
      if (!((sign < 0.0 ? contacts[i].a : contacts[i].b) == mover)) continue;
      const Vector3 force = sign * forces[i].force_W;
      out.force_W += force;
      out.moment_W += cross(0.5 * (contacts[i].p_A_W + contacts[i].p_B_W), force);
    }
  return out;
}

DynamicsWorld::DynamicsWorld(const Settings& settings) : settings_(settings), solver_(settings.solver) {
  validate(settings);
}

std::uint32_t DynamicsWorld::add_body(const RigidBody& body, const RigidBodyState& state) {
  if (!is_finite(state)) throw InputError(indexed("body", bodies_.size()) + ": its state is not finite");
  bodies_.push_back({body, state});
  wake_all();
  return static_cast<std::uint32_t>(bodies_.size() - 1);
}

std::uint32_t DynamicsWorld::add_kinematic(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W) {
  validate_pose(X_WB, indexed("kinematic body", bodies_.size()));
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(indexed("kinematic body", bodies_.size()) + ": velocities are not finite");
  const RigidBody body = unit_body();
  const std::uint32_t index = add_body(body, body.state(X_WB, Vector3::Zero(), Vector3::Zero()));
  bodies_[index].is_kinematic = true;
  bodies_[index].told_v_W = v_W, bodies_[index].told_w_W = w_W;
  count_restless();
  return index;
}

void DynamicsWorld::set_velocity(std::uint32_t kinematic, const Vector3& v_W, const Vector3& w_W) {
  if (kinematic >= bodies_.size() || !bodies_[kinematic].is_kinematic)
    throw InputError(indexed("body", kinematic) + " is not kinematic");
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(indexed("kinematic body", kinematic) + ": velocities are not finite");
  Body& body = bodies_[kinematic];
  const bool moved = moves(body);
  body.told_v_W = v_W, body.told_w_W = w_W;
  if (moves(body) != moved) restless_ = moved ? restless_ - 1 : restless_ + 1;
}

void DynamicsWorld::set_state(std::uint32_t body, const RigidBodyState& state) {
  if (body >= bodies_.size()) throw InputError("no " + indexed("body", body));
  if (!is_finite(state)) throw InputError(indexed("body", body) + ": its state is not finite");
  if (bodies_[body].is_kinematic)
    wake_all();  // what lay on it
  else
    wake(body);
  bodies_[body].state = state;
}

void DynamicsWorld::set_body(std::uint32_t body, const RigidBody& as, const RigidBodyState& state) {
  set_state(body, state);
  bodies_[body].body = as;
  bodies_[body].is_kinematic = false;
  count_restless();
}

void DynamicsWorld::hold_out(std::uint32_t body) {
  wake(body);
  bodies_[body].is_kinematic = true;
  bodies_[body].told_v_W = bodies_[body].told_w_W = Vector3::Zero();
  count_restless();
}

void DynamicsWorld::push(const Mover& mover, const Vector3& force_W, const Vector3& p_W,
                         const Vector3& moment_W) {
  const auto refuse = [&](const char* why) {
    throw InputError(indexed(mover.kind == Mover::Kind::link ? "mechanism" : "body", mover.index) + ": " +
                     why);
  };
  if (mover.kind == Mover::Kind::ground) throw InputError("a push on the ground");
  if (!is_known(mover)) refuse("no such body or link to push");
  if (!touchstone::is_finite(force_W) || !touchstone::is_finite(p_W) || !touchstone::is_finite(moment_W))
    refuse("a push that is not finite");
  if (mover.kind == Mover::Kind::body && bodies_[mover.index].is_kinematic)
    refuse("is kinematic: it is not pushed");
  is_pushed_ = true;
  if (mover.kind == Mover::Kind::body) {
    Body& body = bodies_[mover.index];
    wake(mover.index);
    body.push_W += force_W;
    body.push_moment_W += moment_W + cross(Vector3(p_W - body.state.p_W), force_W);
    return;
  }
  Arm& arm = mechanisms_[mover.index];
  for (const auto& [of, is_turn] : {std::pair(force_W, false), std::pair(moment_W, true)}) {
    const double size = norm(of);
    if (size == 0.0) continue;
    const Vector3 along = of / size;
    if (is_turn)
      arm.dynamics->turn_jacobian(mover.link, along, arm.turned, arm.placed);
    else
      arm.dynamics->point_jacobian(mover.link, p_W, along, arm.turned, arm.placed);
    for (std::size_t k = 0; k < arm.push.size(); ++k) arm.push[k] += size * arm.turned[k];
  }
}

void DynamicsWorld::set_rates(std::uint32_t mechanism, std::span<const double> qd) {
  Arm& arm = mechanisms_[mechanism];
  for (std::size_t i = 0; i < arm.qd.size(); ++i) arm.qd[i] = qd[i];  // they may be its own
  arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
}

void DynamicsWorld::set_joints(std::uint32_t mechanism, std::span<const double> q,
                               std::span<const double> qd) {
  Arm& arm = mechanisms_[mechanism];
  for (std::size_t i = 0; i < arm.q.size(); ++i) arm.q[i] = q[i];
  set_rates(mechanism, qd);
}

std::uint32_t DynamicsWorld::add_mechanism(const MechanismDynamics& dynamics, const Pose& X_WBase,
                                           std::span<const double> q, std::span<const double> qd) {
  const std::string name = "mechanism '" + dynamics.mechanism().name() + "'";
  const std::size_t n = dynamics.size();
  if (q.size() != n || qd.size() != n)
    throw InputError(name + ": " + std::to_string(q.size()) + " values and " + std::to_string(qd.size()) +
                     " rates for " + std::to_string(n) + " joints that move");
  if (!dynamics.mechanism().is_within_limits(q)) throw InputError(name + ": a joint value is out of limits");
  for (const double rate : qd)
    if (!std::isfinite(rate)) throw InputError(name + ": a joint rate is not finite");
  validate_pose(X_WBase, name + ", base");
  Arm& arm = mechanisms_.emplace_back();
  arm.dynamics = &dynamics;
  arm.X_WBase = rigid_frame(X_WBase);
  arm.q.assign(q.begin(), q.end());
  arm.qd.assign(qd.begin(), qd.end());
  for (auto* vector : {&arm.torque, &arm.start_torque, &arm.last_torque, &arm.tau, &arm.change, &arm.kept_q,
                       &arm.kept_qd, &arm.start_q, &arm.start_qd, &arm.flown_q, &arm.flown_qd,
                       &arm.kept_torque, &arm.kept_last_torque, &arm.push, &arm.turned})
    vector->assign(n, 0.0);
  arm.M.resize(n * n);
  arm.drives.resize(n);
  arm.placed = dynamics.make_workspace();
  arm.scratch = dynamics.make_workspace();
  dynamics.place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  for (const Mechanism::Joint& joint : dynamics.mechanism().joints())
    if (joint.value != Mechanism::kNone) arm.drives[joint.value].limit = joint.effort;
  return static_cast<std::uint32_t>(mechanisms_.size() - 1);
}

void DynamicsWorld::set_drive(std::uint32_t mechanism, std::uint32_t value, const JointDrive& drive) {
  if (mechanism >= mechanisms_.size()) throw InputError("no " + indexed("mechanism", mechanism));
  Arm& arm = mechanisms_[mechanism];
  const auto refuse = [&](const char* why) {
    throw InputError("mechanism '" + arm.dynamics->mechanism().name() + "', " + indexed("value", value) +
                     ": " + why);
  };
  if (value >= arm.drives.size()) refuse("no such joint");
  if (!(drive.limit >= 0.0)) refuse("a torque limit below 0");
  if (!std::isfinite(drive.torque) || !std::isfinite(drive.rate)) refuse("torque or rate is not finite");
  arm.drives[value] = drive;
  for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints())
    if (joint.value == value)
      arm.drives[value].rate = std::min(std::max(drive.rate, -joint.rate), joint.rate);
}

void DynamicsWorld::reserve(std::size_t contacts) {
  std::size_t joints = 0, widest = 6;
  for (const Arm& arm : mechanisms_) {
    joints += arm.q.size();
    widest = std::max(widest, arm.q.size());
  }
  const std::size_t rows = 3 * contacts + 3 * joints;  // a joint: its drive, two stops
  const std::size_t units = bodies_.size() + mechanisms_.size(), blocks = contacts + 3 * joints;
  points_.reserve(contacts);
  active_.reserve(contacts);
  warm_.reserve(contacts);
  next_warm_.reserve(contacts);
  carried_.reserve(contacts);
  forces_.reserve(contacts);
  for (auto* vector : {&group_of_contact_, &contact_order_}) vector->reserve(contacts);
  for (auto* vector : {&leader_, &group_of_unit_, &island_of_unit_, &body_order_, &loose_, &kinematics_,
                       &unit_order_, &mechanism_order_})
    vector->reserve(units);
  fill_.reserve(units + 1);
  for (auto* vector : {&patience_, &kept_patience_, &contradicted_, &kept_contradicted_})
    vector->reserve(units);
  for (auto* vector : {&convex_sizes_, &local_unit_}) vector->reserve(units);
  masses_.reserve(units * widest * widest);
  convex_rows_.reserve(rows);
  convex_.reserve(units, rows, widest);
  for (auto* vector : {&residuals_, &scales_}) vector->reserve(blocks);
  groups_.reserve(units);
  islands_.reserve(units);
  block_order_.reserve(blocks);
  island_of_block_.reserve(blocks);
  joint_rows_.reserve(3 * joints);
  for (auto* vector : {&bounds_, &local_bounds_}) vector->reserve(3 * joints);
  rows_.reserve(rows);
  local_rows_.reserve(rows);
  for (auto* vector : {&b_, &x_, &u_, &local_b_, &local_x_, &warm_x_}) vector->reserve(rows);
  for (auto* vector : {&friction_, &local_friction_}) vector->reserve(contacts);
  for (auto* vector : {&J_, &Y_}) vector->reserve(2 * widest * rows);
  // Of the largest island: who expects larger ones than a thousand rows pays for them when they come.
  const std::size_t island_rows = std::min<std::size_t>(rows, 1024);
  W_.reserve(island_rows * island_rows);
  solver_.reserve(island_rows);
}

std::uint32_t DynamicsWorld::unit_of(const Mover& mover) const {
  if (mover.kind == Mover::Kind::link) return static_cast<std::uint32_t>(bodies_.size()) + mover.index;
  return mover.kind == Mover::Kind::body && !bodies_[mover.index].is_kinematic ? mover.index : kNone;
}

Vector3 DynamicsWorld::velocity(std::uint32_t body) const {
  const Body& b = bodies_[body];
  return b.is_kinematic ? b.told_v_W : b.body.velocity(b.state);
}

Vector3 DynamicsWorld::angular_velocity(std::uint32_t body) const {
  const Body& b = bodies_[body];
  return b.is_kinematic ? b.told_w_W : b.body.angular_velocity(b.state);
}

Pose DynamicsWorld::link_pose(std::uint32_t mechanism, std::uint32_t link) const {
  const Arm& arm = mechanisms_[mechanism];
  return arm.dynamics->link_pose(link, arm.placed);
}

Vector3 DynamicsWorld::velocity_at(const Mover& mover, const Vector3& p_W) const {
  if (mover.kind == Mover::Kind::body)
    return velocity(mover.index) + cross(angular_velocity(mover.index), p_W - bodies_[mover.index].state.p_W);
  return point_velocity(mover, p_W);
}

Vector3 DynamicsWorld::link_angular_velocity(std::uint32_t mechanism, std::uint32_t link) const {
  const Arm& arm = mechanisms_[mechanism];
  return arm.dynamics->angular_velocity(link, arm.placed);
}

Vector3 DynamicsWorld::linear_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (const Body& b : bodies_)
    if (!b.is_kinematic) sum += b.state.momentum_W;
  for (const Arm& arm : mechanisms_) sum += arm.dynamics->linear_momentum(arm.placed);
  return sum;
}

Vector3 DynamicsWorld::angular_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (const Body& b : bodies_)
    if (!b.is_kinematic) sum += cross(b.state.p_W, b.state.momentum_W) + b.state.angular_W;
  for (const Arm& arm : mechanisms_) sum += arm.dynamics->angular_momentum(arm.placed);
  return sum;
}

double DynamicsWorld::energy() const {
  double sum = 0.0;
  for (const Body& b : bodies_)
    if (!b.is_kinematic)
      sum += b.body.kinetic_energy(b.state) - b.body.inertia().mass * dot(settings_.gravity_W, b.state.p_W);
  for (const Arm& arm : mechanisms_)
    sum += arm.dynamics->kinetic_energy(arm.placed) +
           arm.dynamics->potential_energy(settings_.gravity_W, arm.placed);
  return sum;
}

}  // namespace touchstone::physics
