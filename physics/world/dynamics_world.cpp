#include "touchstone/physics/world/dynamics_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/physics/solver/reserved.hpp"
#include "touchstone/physics/world/groups/sleep.hpp"
#include "touchstone/physics/world/step/trial_steps.hpp"
#include "touchstone/physics/world/step/world_parts.hpp"

namespace touchstone::physics {

using namespace stepping;

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
      return "the scene's action has no place: what it latches, lets go, adds or removes is held, free, "
             "there or gone by a command, or would have an inertia that is none to rounding";
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

DynamicsWorld::DynamicsWorld(const Settings& settings) {
  validate(settings);
  parts_ = std::make_unique<Parts>(settings);
}
DynamicsWorld::~DynamicsWorld() = default;
DynamicsWorld::DynamicsWorld(const DynamicsWorld& other) : parts_(std::make_unique<Parts>(*other.parts_)) {}
DynamicsWorld& DynamicsWorld::operator=(const DynamicsWorld& other) {
  if (parts_)
    *parts_ = *other.parts_;
  else
    parts_ = std::make_unique<Parts>(*other.parts_);
  return *this;
}
DynamicsWorld::DynamicsWorld(DynamicsWorld&& other) noexcept = default;
DynamicsWorld& DynamicsWorld::operator=(DynamicsWorld&& other) noexcept = default;

std::uint32_t DynamicsWorld::add_body(const RigidBody& body, const RigidBodyState& state) {
  if (!is_finite(state))
    throw InputError(indexed("body", parts_->movers.bodies.size()) + ": its state is not finite");
  parts_->movers.bodies.push_back({body, state});
  wake_all(parts_->movers);
  return static_cast<std::uint32_t>(parts_->movers.bodies.size() - 1);
}

std::uint32_t DynamicsWorld::add_kinematic(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W) {
  validate_pose(X_WB, indexed("kinematic body", parts_->movers.bodies.size()));
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(indexed("kinematic body", parts_->movers.bodies.size()) + ": velocities are not finite");
  const RigidBody body = unit_body();
  const std::uint32_t index = add_body(body, body.state(X_WB, Vector3::Zero(), Vector3::Zero()));
  parts_->movers.bodies[index].is_kinematic = true;
  parts_->movers.bodies[index].commanded_v_W = v_W, parts_->movers.bodies[index].commanded_w_W = w_W;
  count_restless(parts_->movers);
  return index;
}

void DynamicsWorld::set_velocity(std::uint32_t kinematic, const Vector3& v_W, const Vector3& w_W) {
  if (kinematic >= parts_->movers.bodies.size() || !parts_->movers.bodies[kinematic].is_kinematic)
    throw InputError(indexed("body", kinematic) + " is not kinematic");
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(indexed("kinematic body", kinematic) + ": velocities are not finite");
  Body& body = parts_->movers.bodies[kinematic];
  const bool moved = moves(body);
  body.commanded_v_W = v_W, body.commanded_w_W = w_W;
  if (moves(body) != moved) parts_->movers.restless += moved ? -1 : 1;
}

void DynamicsWorld::set_state(std::uint32_t body, const RigidBodyState& state) {
  if (body >= parts_->movers.bodies.size()) throw InputError("no " + indexed("body", body));
  if (!is_finite(state)) throw InputError(indexed("body", body) + ": its state is not finite");
  if (parts_->movers.bodies[body].is_kinematic)
    wake_all(parts_->movers);  // what lay on it
  else
    wake(body);
  parts_->movers.bodies[body].state = state;
}

void DynamicsWorld::set_body(std::uint32_t body, const RigidBody& as, const RigidBodyState& state) {
  set_state(body, state);
  parts_->movers.bodies[body].body = as;
  parts_->movers.bodies[body].is_kinematic = false;
  count_restless(parts_->movers);
}

void DynamicsWorld::hold_out(std::uint32_t body) {
  wake(body);
  parts_->movers.bodies[body].is_kinematic = true;
  parts_->movers.bodies[body].commanded_v_W = parts_->movers.bodies[body].commanded_w_W = Vector3::Zero();
  count_restless(parts_->movers);
}

void DynamicsWorld::push(const Mover& mover, const Vector3& force_W, const Vector3& p_W,
                         const Vector3& moment_W) {
  const auto refuse = [&](const char* why) {
    throw InputError(indexed(mover.kind == Mover::Kind::link ? "mechanism" : "body", mover.index) + ": " +
                     why);
  };
  // The ground, unknown and kinematic movers and pushes that are not finite are refused.
  if (mover.kind == Mover::Kind::ground) throw InputError("a push on the ground");
  if (!parts_->movers.is_known(mover)) refuse("no such body or link to push");
  if (!touchstone::is_finite(force_W) || !touchstone::is_finite(p_W) || !touchstone::is_finite(moment_W))
    refuse("a push that is not finite");
  if (mover.kind == Mover::Kind::body && parts_->movers.bodies[mover.index].is_kinematic)
    refuse("is kinematic: it is not pushed");
  // A body collects the force and its moment about the centre of mass.
  parts_->movers.is_pushed = true;
  if (mover.kind == Mover::Kind::body) {
    Body& body = parts_->movers.bodies[mover.index];
    wake(mover.index);
    body.push_W += force_W;
    body.push_moment_W += moment_W + cross(Vector3(p_W - body.state.p_W), force_W);
    return;
  }
  // A mechanism collects generalised forces.
  Arm& arm = parts_->movers.arms[mover.index];
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
  Arm& arm = parts_->movers.arms[mechanism];
  for (std::size_t i = 0; i < arm.qd.size(); ++i) arm.qd[i] = qd[i];  // they may be its own
  arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
}

void DynamicsWorld::set_joints(std::uint32_t mechanism, std::span<const double> q,
                               std::span<const double> qd) {
  Arm& arm = parts_->movers.arms[mechanism];
  for (std::size_t i = 0; i < arm.q.size(); ++i) arm.q[i] = q[i];
  set_rates(mechanism, qd);
}

std::uint32_t DynamicsWorld::add_mechanism(const MechanismDynamics& dynamics, const Pose& X_WBase,
                                           std::span<const double> q, std::span<const double> qd) {
  const std::string name = "mechanism '" + dynamics.mechanism().name() + "'";
  const std::size_t n = dynamics.size();
  // Values, rates and the base's pose are checked.
  if (q.size() != n || qd.size() != n)
    throw InputError(name + ": " + std::to_string(q.size()) + " values and " + std::to_string(qd.size()) +
                     " rates for " + std::to_string(n) + " joints that move");
  if (!dynamics.mechanism().is_within_limits(q)) throw InputError(name + ": a joint value is out of limits");
  for (const double rate : qd)
    if (!std::isfinite(rate)) throw InputError(name + ": a joint rate is not finite");
  validate_pose(X_WBase, name + ", base");
  // The mechanism starts in that state.
  Arm& arm = parts_->movers.arms.emplace_back();
  arm.dynamics = &dynamics;
  arm.X_WBase = rigid_frame(X_WBase);
  arm.q.assign(q.begin(), q.end());
  arm.qd.assign(qd.begin(), qd.end());
  // Its memory is sized by the number of joints.
  for (auto* vector :
       {&arm.torque, &arm.start_torque, &arm.tau, &arm.change, &arm.kept_q, &arm.kept_qd, &arm.start_q,
        &arm.start_qd, &arm.flown_q, &arm.flown_qd, &arm.kept_torque, &arm.push, &arm.turned, &arm.reach})
    vector->assign(n, 0.0);
  for (auto* vector : {&arm.last_torque, &arm.kept_last_torque}) vector->assign(stepping::kTorques * n, 0.0);
  arm.losses.resize(n);
  arm.M.resize(n * n);
  arm.drives.resize(n);
  arm.placed = dynamics.make_workspace();
  arm.scratch = dynamics.make_workspace();
  // Its links are placed, and its drives limited by the joints' efforts.
  dynamics.place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  for (const Mechanism::Joint& joint : dynamics.mechanism().joints())
    if (joint.value != Mechanism::kNone) arm.drives[joint.value].limit = joint.effort;
  return static_cast<std::uint32_t>(parts_->movers.arms.size() - 1);
}

void DynamicsWorld::set_drive(std::uint32_t mechanism, std::uint32_t value, const JointDrive& drive) {
  if (mechanism >= parts_->movers.arms.size()) throw InputError("no " + indexed("mechanism", mechanism));
  Arm& arm = parts_->movers.arms[mechanism];
  const auto refuse = [&](const char* why) {
    throw InputError("mechanism '" + arm.dynamics->mechanism().name() + "', " + indexed("value", value) +
                     ": " + why);
  };
  if (value >= arm.drives.size()) refuse("no such joint");
  if (!(drive.limit >= 0.0)) refuse("a torque limit below 0");
  if (!std::isfinite(drive.torque) || !std::isfinite(drive.rate) || !std::isfinite(drive.position))
    refuse("torque, rate or position is not finite");
  if (!is_at_least_0(drive.stiffness) || !is_at_least_0(drive.damping))
    refuse("stiffness and damping must be >= 0 and finite");
  arm.drives[value] = drive;
  for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints())
    if (joint.value == value)
      arm.drives[value].rate = std::min(std::max(drive.rate, -joint.rate), joint.rate);
}

void DynamicsWorld::set_losses(std::uint32_t mechanism, std::uint32_t value, const JointLosses& losses) {
  if (mechanism >= parts_->movers.arms.size()) throw InputError("no " + indexed("mechanism", mechanism));
  Arm& arm = parts_->movers.arms[mechanism];
  const auto refuse = [&](const char* why) {
    throw InputError("mechanism '" + arm.dynamics->mechanism().name() + "', " + indexed("value", value) +
                     ": " + why);
  };
  if (value >= arm.losses.size()) refuse("no such joint");
  if (!is_at_least_0(losses.friction) || !is_at_least_0(losses.damping))
    refuse("friction and damping must be >= 0 and finite");
  arm.losses[value] = losses;
}

void DynamicsWorld::reserve(std::size_t contacts) {
  WorldParts& world = *parts_;
  std::size_t joints = 0, widest = 6;
  for (const Arm& arm : world.movers.arms) {
    joints += arm.q.size();
    widest = std::max(widest, arm.q.size());
  }
  const std::size_t held = world.movers.joints.size();
  const std::size_t joint_rows =
      stepping::kJointRows * joints + (stepping::kJointRows + BodyJoint::kMostRows) * held;
  const std::size_t units = world.movers.unit_count(), blocks = contacts + joint_rows;
  world.warm.reserve(contacts);
  world.groups.reserve(contacts, units, held);
  if (held > 0) {
    world.movers.system.reserve(std::min(world.movers.bodies.size(), 2 * held),
                                std::min(world.movers.arms.size(), 2 * held), held, widest);
    reserve_written(world.movers.system_index, units);
  }
  for (auto* vector : {&world.group.points, &world.group.spare}) reserve_written(*vector, contacts);
  reserve_written(world.group.kinematics, units);
  world.rows.reserve(contacts, joint_rows, units, widest);
  world.solver.reserve(world.rows, units, blocks, widest);
  reserve_written(world.forces, contacts);
  // Code is cold once a process.
  [[maybe_unused]] static const StepFailure trial = stepping::take_trial_steps();
}

void DynamicsWorld::forget_pushes() { parts_->movers.forget_pushes(); }

bool DynamicsWorld::is_asleep(std::uint32_t body) const { return parts_->movers.bodies[body].is_asleep; }
std::uint32_t DynamicsWorld::first_of_sleepers(std::uint32_t body) const {
  return parts_->movers.bodies[body].first_sleeper;
}
std::uint32_t DynamicsWorld::sleepers() const { return parts_->movers.sleepers; }
bool DynamicsWorld::is_at_rest() const { return parts_->movers.restless == 0 && parts_->movers.arms.empty(); }
bool DynamicsWorld::is_restless(const Mover& mover) const {
  return stepping::is_restless(parts_->movers, mover);
}
void DynamicsWorld::wake(std::uint32_t body) { stepping::wake(parts_->movers, body); }

const DynamicsWorld::Settings& DynamicsWorld::settings() const { return parts_->settings; }
std::size_t DynamicsWorld::body_count() const { return parts_->movers.bodies.size(); }
bool DynamicsWorld::is_kinematic(std::uint32_t body) const {
  return parts_->movers.bodies[body].is_kinematic;
}
const RigidBody& DynamicsWorld::body(std::uint32_t body) const { return parts_->movers.bodies[body].body; }
const RigidBodyState& DynamicsWorld::state(std::uint32_t body) const {
  return parts_->movers.bodies[body].state;
}

Pose DynamicsWorld::pose(std::uint32_t body) const {
  const Body& b = parts_->movers.bodies[body];
  return b.body.pose(b.state);
}

std::span<const double> DynamicsWorld::joint_values(std::uint32_t mechanism) const {
  return parts_->movers.arms[mechanism].q;
}
std::span<const double> DynamicsWorld::joint_rates(std::uint32_t mechanism) const {
  return parts_->movers.arms[mechanism].qd;
}
std::span<const double> DynamicsWorld::joint_torques(std::uint32_t mechanism) const {
  return parts_->movers.arms[mechanism].torque;
}

Vector3 DynamicsWorld::velocity(std::uint32_t body) const {
  const Body& b = parts_->movers.bodies[body];
  return b.is_kinematic ? b.commanded_v_W : b.body.velocity(b.state);
}

Vector3 DynamicsWorld::angular_velocity(std::uint32_t body) const {
  const Body& b = parts_->movers.bodies[body];
  return b.is_kinematic ? b.commanded_w_W : b.body.angular_velocity(b.state);
}

Pose DynamicsWorld::link_pose(std::uint32_t mechanism, std::uint32_t link) const {
  const Arm& arm = parts_->movers.arms[mechanism];
  return arm.dynamics->link_pose(link, arm.placed);
}

Vector3 DynamicsWorld::velocity_at(const Mover& mover, const Vector3& p_W) const {
  if (mover.kind == Mover::Kind::body)
    return velocity(mover.index) +
           cross(angular_velocity(mover.index), p_W - parts_->movers.bodies[mover.index].state.p_W);
  return parts_->movers.point_velocity(mover, p_W);
}

Vector3 DynamicsWorld::link_angular_velocity(std::uint32_t mechanism, std::uint32_t link) const {
  const Arm& arm = parts_->movers.arms[mechanism];
  return arm.dynamics->angular_velocity(link, arm.placed);
}

StepReport DynamicsWorld::step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces) {
  return take_step(h, contacts, forces, *parts_);
}

Vector3 DynamicsWorld::linear_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (const Body& b : parts_->movers.bodies)
    if (!b.is_kinematic) sum += b.state.momentum_W;
  for (const Arm& arm : parts_->movers.arms) sum += arm.dynamics->linear_momentum(arm.placed);
  return sum;
}

Vector3 DynamicsWorld::angular_momentum() const {
  Vector3 sum = Vector3::Zero();
  for (const Body& b : parts_->movers.bodies)
    if (!b.is_kinematic) sum += cross(b.state.p_W, b.state.momentum_W) + b.state.angular_W;
  for (const Arm& arm : parts_->movers.arms) sum += arm.dynamics->angular_momentum(arm.placed);
  return sum;
}

double DynamicsWorld::energy() const {
  double sum = 0.0;
  for (const Body& b : parts_->movers.bodies)
    if (!b.is_kinematic)
      sum += b.body.kinetic_energy(b.state) -
             b.body.inertia().mass * dot(parts_->settings.gravity_W, b.state.p_W);
  for (const Arm& arm : parts_->movers.arms)
    sum += arm.dynamics->kinetic_energy(arm.placed) +
           arm.dynamics->potential_energy(parts_->settings.gravity_W, arm.placed);
  return sum;
}

}  // namespace touchstone::physics
