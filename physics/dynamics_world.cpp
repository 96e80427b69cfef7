#include "physics/dynamics_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "contact_core/input_error.hpp"
#include "physics/cholesky.hpp"
#include "physics/contact_laws.hpp"
#include "physics/matrix3.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A piece of a step that is this close to its whole is the whole.
constexpr double kWhole = 1.0 - 1e-6;
// Arrivals tried for one piece: each try lands closer by the square of what is left.
constexpr int kMostTries = 6;
// Where points stop one by one (a body that turns as it slides) their stops are many and none is sharp: this
// many pieces of a step end at one, each found in at most two tries.
constexpr std::uint32_t kMostStops = 4;
constexpr int kStopTries = 2;

/// Two directions at right angles to n and each other.
void tangents(const Vector3& n, Vector3& t1, Vector3& t2) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(n[i]) < std::abs(n[least])) least = i;
  t1 = cross(n, Vector3(Vector3::Unit(least)));
  t1 = t1 / norm(t1);
  t2 = cross(n, t1);
}

/// Contacts mostly come in the same order: what one had in the last step is looked for a little way on from
/// where the one before was found, so that many of them do not cost their square.
constexpr std::size_t kReach = 64;

RigidBody unit_body() { return {box_inertia(1.0, {1, 1, 1}), "unit"}; }

double cut_torque(const JointDrive& drive) {
  return std::min(std::max(drive.torque, -drive.limit), drive.limit);
}

std::string indexed(const char* what, std::size_t index) { return what + (" " + std::to_string(index)); }

}  // namespace

std::string_view to_string(StepFailure failure) {
  constexpr std::array<std::string_view, 4> kNames{"none", "bad_contact", "body", "mechanism"};
  return kNames[static_cast<std::size_t>(failure)];
}

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

// ---- set-up

DynamicsWorld::DynamicsWorld(const Settings& settings) : settings_(settings), solver_(settings.solver) {
  if (!touchstone::is_finite(settings.gravity_W)) throw InputError("dynamics: gravity is not finite");
  if (!(settings.contact_gap > 0.0) || !(settings.bounce_speed >= 0.0) || !(settings.push_out >= 0.0))
    throw InputError("dynamics: the contact gap must be > 0, bounce speed and push-out >= 0");
  if (settings.most_substeps == 0) throw InputError("dynamics: a step has at least one piece");
}

std::uint32_t DynamicsWorld::add_body(const RigidBody& body, const RigidBodyState& state) {
  if (!is_finite(state)) throw InputError(indexed("body", bodies_.size()) + ": its state is not finite");
  bodies_.push_back({body, state});
  return static_cast<std::uint32_t>(bodies_.size() - 1);
}

std::uint32_t DynamicsWorld::add_kinematic(const Pose& X_WB, const Vector3& v_W, const Vector3& w_W) {
  validate_pose(X_WB, indexed("kinematic body", bodies_.size()));
  const RigidBody body = unit_body();
  const std::uint32_t index = add_body(body, body.state(X_WB, Vector3::Zero(), Vector3::Zero()));
  bodies_[index].is_kinematic = true;
  bodies_[index].v_W = v_W, bodies_[index].w_W = w_W;
  return index;
}

void DynamicsWorld::set_velocity(std::uint32_t kinematic, const Vector3& v_W, const Vector3& w_W) {
  if (kinematic >= bodies_.size() || !bodies_[kinematic].is_kinematic)
    throw InputError(indexed("body", kinematic) + " is not kinematic");
  if (!touchstone::is_finite(v_W) || !touchstone::is_finite(w_W))
    throw InputError(indexed("kinematic body", kinematic) + ": velocities are not finite");
  bodies_[kinematic].v_W = v_W, bodies_[kinematic].w_W = w_W;
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
                       &arm.kept_qd, &arm.start_q, &arm.start_qd, &arm.flown_q, &arm.flown_qd})
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
  const std::string name = "mechanism '" + arm.dynamics->mechanism().name() + "', " + indexed("value", value);
  if (value >= arm.drives.size()) throw InputError(name + ": no such joint");
  if (!(drive.limit >= 0.0)) throw InputError(name + ": a torque limit below 0");
  if (!std::isfinite(drive.torque) || !std::isfinite(drive.rate))
    throw InputError(name + ": torque or rate is not finite");
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
  points_.reserve(contacts);
  active_.reserve(contacts);
  warm_.reserve(contacts);
  friction_.reserve(contacts);
  joint_rows_.reserve(3 * joints);
  bounds_.reserve(3 * joints);
  rows_.reserve(rows);
  for (auto* vector : {&b_, &x_, &u_, &local_b_, &local_x_, &local_u_}) vector->reserve(rows);
  J_.reserve(2 * widest * rows);
  Y_.reserve(2 * widest * rows);
  local_friction_.reserve(contacts);
  local_bounds_.reserve(3 * joints);
  local_rows_.reserve(rows);
  for (auto* vector : {&block_order_, &island_of_block_}) vector->reserve(contacts + 3 * joints);
  const std::size_t units = bodies_.size() + mechanisms_.size();
  leader_.reserve(units);
  first_of_unit_.reserve(units);
  spread_.reserve(6 * bodies_.size() + joints);
  island_of_unit_.reserve(units);
  islands_.reserve(units);
  // Of the largest island: who expects larger ones than a thousand rows pays for them when they come.
  const std::size_t island_rows = std::min<std::size_t>(rows, 1024);
  W_.reserve(island_rows * island_rows);
  solver_.reserve(island_rows);
}

// ---- where things are

Vector3 DynamicsWorld::velocity(std::uint32_t body) const {
  const Body& b = bodies_[body];
  return b.is_kinematic ? b.v_W : b.body.velocity(b.state);
}

Vector3 DynamicsWorld::angular_velocity(std::uint32_t body) const {
  const Body& b = bodies_[body];
  return b.is_kinematic ? b.w_W : b.body.angular_velocity(b.state);
}

Pose DynamicsWorld::link_pose(std::uint32_t mechanism, std::uint32_t link) const {
  const Arm& arm = mechanisms_[mechanism];
  return arm.dynamics->link_pose(link, arm.placed);
}

Pose DynamicsWorld::mover_pose(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return pose(mover.index);
  if (mover.kind == Mover::Kind::link) return link_pose(mover.index, mover.link);
  return {};
}

Vector3 DynamicsWorld::point_velocity(const Mover& mover, const Vector3& p_W) const {
  if (mover.kind == Mover::Kind::body)
    return velocity(mover.index) + cross(angular_velocity(mover.index), p_W - bodies_[mover.index].state.p_W);
  if (mover.kind == Mover::Kind::link) {
    const Arm& arm = mechanisms_[mover.index];
    return arm.dynamics->point_velocity(mover.link, p_W, arm.placed);
  }
  return Vector3::Zero();
}

Vector3 DynamicsWorld::relative_velocity(const Point& point) const {
  return point_velocity(point.contact.b, point.p_W) - point_velocity(point.contact.a, point.p_W);
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

// ---- contacts of a step

bool DynamicsWorld::is_known(const Mover& mover) const {
  if (mover.kind == Mover::Kind::body) return mover.index < bodies_.size();
  if (mover.kind == Mover::Kind::link)
    return mover.index < mechanisms_.size() &&
           mover.link < mechanisms_[mover.index].dynamics->mechanism().links().size();
  return true;
}

bool DynamicsWorld::check(std::span<const Contact> contacts, StepReport& report) const {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const bool is_good = is_known(c.a) && is_known(c.b) && touchstone::is_finite(c.p_A_W) &&
                         touchstone::is_finite(c.p_B_W) &&
                         std::abs(dot(c.n_AB_W, c.n_AB_W) - 1.0) <= kRotationTolerance && c.friction >= 0.0 &&
                         std::isfinite(c.friction) && c.restitution >= 0.0 && c.restitution <= 1.0;
    if (is_good) continue;
    report.failure = StepFailure::bad_contact;
    report.failed_index = static_cast<std::uint32_t>(i);
    return false;
  }
  return true;
}

void DynamicsWorld::attach(std::span<const Contact> contacts) {
  points_.clear();
  std::size_t next = 0;
  for (const Contact& contact : contacts) {
    Point& point = points_.emplace_back();
    point.contact = contact;
    point.p_A = touchstone::transform(inverse(mover_pose(contact.a)), contact.p_A_W);
    point.p_B = touchstone::transform(inverse(mover_pose(contact.b)), contact.p_B_W);
    tangents(contact.n_AB_W, point.t1_W, point.t2_W);
    point.impulse_W = point.impact_W = Vector3::Zero();
    point.is_new = !take_by_key(point, next);
  }
  next = 0;
  for (Point& point : points_) take_nearest(point, next);
}

/// What the contact of this name had in the last step, if there was one.
bool DynamicsWorld::take_by_key(Point& point, std::size_t& next) {
  point.last_force_W = Vector3::Zero();
  if (point.contact.key == 0) return false;
  for (std::size_t i = 0; i < std::min(kReach, warm_.size()); ++i) {
    Warm& warm = warm_[(next + i) % warm_.size()];
    if (warm.key != point.contact.key) continue;
    next = (next + i + 1) % warm_.size();
    point.last_force_W = warm.force_W;
    warm.is_taken = true;
    return true;
  }
  return false;
}

/// Where corners lie on edges, a point's feature is named one way or another as rounding will have it: a
/// point of a new name goes on with what the nearest of the same movers' points had whose name is gone.
void DynamicsWorld::take_nearest(Point& point, std::size_t& next) {
  const auto is_pair = [&](const Warm& warm) {
    return warm.a == point.contact.a && warm.b == point.contact.b;
  };
  if (point.contact.key == 0) return;
  const std::size_t reach = std::min(kReach, warm_.size());
  Warm* nearest = nullptr;
  double least = kInfinity;
  for (std::size_t i = 0; i < reach; ++i) {
    const std::size_t at = (next + i) % warm_.size();
    if (!is_pair(warm_[at])) {
      if (nearest != nullptr) break;
      continue;
    }
    if (!point.is_new) {
      next = at;  // the first of this pair's
      return;
    }
    const double distance = norm(warm_[at].p_A - point.p_A);
    if (!warm_[at].is_taken && distance < least) least = distance, nearest = &warm_[at];
  }
  if (nearest == nullptr) return;
  point.last_force_W = nearest->force_W;
  nearest->is_taken = true;
}

/// Where the points are now, the normal kept as it was.
void DynamicsWorld::refresh() {
  for (Point& point : points_) {
    const Vector3 p_A = touchstone::transform(mover_pose(point.contact.a), point.p_A);
    const Vector3 p_B = touchstone::transform(mover_pose(point.contact.b), point.p_B);
    point.separation = dot(point.contact.n_AB_W, p_B - p_A);
    point.p_W = 0.5 * (p_A + p_B);
  }
}

// ---- rows

void DynamicsWorld::factor_masses() {
  for (Arm& arm : mechanisms_) {
    arm.dynamics->mass_matrix(arm.M, arm.placed);
    factor_cholesky(arm.M, arm.q.size());
  }
}

void DynamicsWorld::add_side(Row& row, const Mover& mover, const Point& point, const Vector3& direction_W,
                             double sign, Phase phase) {
  const bool is_link = mover.kind == Mover::Kind::link;
  if (mover.kind == Mover::Kind::ground || (!is_link && bodies_[mover.index].is_kinematic)) return;
  const std::size_t size = is_link ? mechanisms_[mover.index].q.size() : 6;
  Side& side = row.sides[row.count++];
  side = {mover, J_.size(), size};
  J_.resize(J_.size() + size);
  Y_.resize(J_.size());
  const std::span<double> J = std::span(J_).subspan(side.first, size),
                          Y = std::span(Y_).subspan(side.first, size);
  if (is_link) {
    const Arm& arm = mechanisms_[mover.index];
    arm.dynamics->point_jacobian(mover.link, point.p_W, sign * direction_W, J, arm.placed);
    std::copy(J.begin(), J.end(), Y.begin());
    solve_cholesky(arm.M, Y);
    return;
  }
  const Body& body = bodies_[mover.index];
  const Vector3 linear = sign * direction_W;
  // Forces act over the piece: about the middle of the body's way, and turn it as it stands at the end.
  const RigidBodyState& state = phase == Phase::impact ? body.state : body.flown;
  const Vector3 angular = cross(point.act_W - 0.5 * (body.state.p_W + state.p_W), linear);
  const Vector3 v = linear / body.body.inertia().mass;
  const Vector3 w = rotate(body.row_inverse_W, angular);
  for (int i = 0; i < 3; ++i) {
    J[i] = linear[i], J[3 + i] = angular[i];
    Y[i] = v[i], Y[3 + i] = w[i];
  }
}

/// Before impulses: at the start of an impact, or after free flight.
double DynamicsWorld::velocity_of(const Row& row, Phase phase) const {
  double sum = 0.0;
  for (int s = 0; s < row.count; ++s) {
    const Side& side = row.sides[s];
    const double* const J = &J_[side.first];
    if (side.mover.kind == Mover::Kind::link) {
      const Arm& arm = mechanisms_[side.mover.index];
      const std::vector<double>& rates = phase == Phase::impact ? arm.qd : arm.flown_qd;
      for (std::size_t k = 0; k < side.size; ++k) sum += J[k] * rates[k];
    } else {
      const Body& body = bodies_[side.mover.index];
      const Vector3 &v = body.row_v_W, &w = body.row_w_W;
      sum += (J[0] * v[0] + J[1] * v[1]) + J[2] * v[2];
      sum += (J[3] * w[0] + J[4] * w[1]) + J[5] * w[2];
    }
  }
  return sum;
}

void DynamicsWorld::add_contact_rows(std::size_t index, Phase phase, double t) {
  Point& point = points_[index];
  const Contact& contact = point.contact;
  // The point goes along with what touches there, half with each.
  point.act_W = phase == Phase::impact
                    ? point.p_W
                    : Vector3(point.p_W + (0.25 * t) * (point_velocity(contact.a, point.p_W) +
                                                        point_velocity(contact.b, point.p_W)));
  const Vector3 directions[3] = {contact.n_AB_W, point.t1_W, point.t2_W};
  const auto told = [&](const Mover& mover, const Vector3& direction) {
    const bool is_told = mover.kind == Mover::Kind::body && bodies_[mover.index].is_kinematic;
    return is_told ? dot(direction, point_velocity(mover, point.p_W)) : 0.0;
  };
  for (int i = 0; i < 3; ++i) {
    Row& row = rows_.emplace_back();
    row.count = 0;
    add_side(row, contact.a, point, directions[i], -1.0, phase);
    add_side(row, contact.b, point, directions[i], 1.0, phase);
    b_.push_back(velocity_of(row, phase) + (told(contact.b, directions[i]) - told(contact.a, directions[i])));
    x_.push_back(phase == Phase::impact ? 0.0 : t * dot(directions[i], point.last_force_W));
  }
  double& normal = b_[b_.size() - 3];
  const double gap = settings_.contact_gap;
  if (phase == Phase::impact) {
    if (normal < -settings_.bounce_speed) normal *= 1.0 + contact.restitution;
  } else if (point.separation > gap) {
    normal += point.separation / t;
  } else if (point.separation < -gap) {
    normal += settings_.push_out * (point.separation + gap);
  }
  friction_.push_back(contact.friction);
  active_.push_back(index);
}

void DynamicsWorld::add_joint_row(const JointRow& joint, double b, ContactProblem::Bounds bounds,
                                  double warm) {
  const Arm& arm = mechanisms_[joint.mechanism];
  const std::size_t n = arm.q.size();
  Row& row = rows_.emplace_back();
  row.count = 1;
  row.sides[0] = {Mover::of_link(joint.mechanism, 0), J_.size(), n};
  J_.resize(J_.size() + n, 0.0);
  Y_.resize(J_.size(), 0.0);
  J_[row.sides[0].first + joint.value] = joint.sign;
  Y_[row.sides[0].first + joint.value] = joint.sign;
  solve_cholesky(arm.M, std::span(Y_).subspan(row.sides[0].first, n));
  b_.push_back(b);
  x_.push_back(warm);
  bounds_.push_back(bounds);
  joint_rows_.push_back(joint);
}

void DynamicsWorld::add_joint_rows(std::uint32_t mechanism, Phase phase, double t, bool all) {
  const Arm& arm = mechanisms_[mechanism];
  for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
    const std::uint32_t i = joint.value;
    if (i == Mechanism::kNone) continue;
    const JointDrive& drive = arm.drives[i];
    const double rate = phase == Phase::impact ? arm.qd[i] : arm.flown_qd[i];
    // In no time only a drive of unlimited torque gives an impulse.
    if (drive.mode != JointDrive::Mode::torque && (phase == Phase::forces || drive.limit == kInfinity)) {
      const double target = drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0;
      const double most = drive.limit == kInfinity ? kInfinity : drive.limit * t;
      add_joint_row({mechanism, i, 1.0, false}, rate - target, {-most, most}, t * arm.last_torque[i]);
    }
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0.0 ? joint.lower : joint.upper;
      const double room = sign * (arm.q[i] - limit);
      const bool is_open = !(room <= settings_.contact_gap);
      if (std::isinf(limit) || (is_open && !all)) continue;
      add_joint_row({mechanism, i, sign, true}, sign * rate + (is_open ? room / t : 0.0), {0.0, kInfinity},
                    0.0);
    }
  }
}

/// @param all points and stops that are apart, too: they may be approached as far as they are.
void DynamicsWorld::gather(Phase phase, double t, bool all) {
  active_.clear();
  rows_.clear();
  joint_rows_.clear();
  for (auto* vector : {&J_, &Y_, &b_, &x_, &friction_}) vector->clear();
  bounds_.clear();
  for (Body& body : bodies_) {
    if (body.is_kinematic) continue;
    const RigidBodyState& state = phase == Phase::impact ? body.state : body.flown;
    body.row_v_W = body.body.velocity(state);
    body.row_w_W = body.body.angular_velocity(state);
    body.row_inverse_W = body.body.inverse_inertia_W(state);
  }
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (all || points_[i].separation <= settings_.contact_gap) add_contact_rows(i, phase, t);
  for (std::uint32_t m = 0; m < mechanisms_.size(); ++m) add_joint_rows(m, phase, t, all);
}

std::size_t DynamicsWorld::unit_of(const Mover& mover) const {
  return mover.kind == Mover::Kind::link ? bodies_.size() + mover.index : mover.index;
}

std::size_t DynamicsWorld::leader_of(std::size_t unit) {
  while (leader_[unit] != unit) unit = leader_[unit] = leader_[leader_[unit]];
  return unit;
}

/// Rows that do not meet, directly or through others, are problems of their own. Islands come in the order of
/// their first row, rows in theirs. Contacts that move nothing are in none.
void DynamicsWorld::find_islands() {
  const std::size_t units = bodies_.size() + mechanisms_.size();
  leader_.resize(units);
  for (std::size_t i = 0; i < units; ++i) leader_[i] = i;
  for (const Row& row : rows_)
    if (row.count == 2)
      leader_[leader_of(unit_of(row.sides[1].mover))] = leader_of(unit_of(row.sides[0].mover));
  island_of_unit_.assign(units, kNoIsland);
  islands_.clear();
  const std::size_t blocks = active_.size() + joint_rows_.size();
  island_of_block_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) {
    const Row& row = rows_[first_row(i)];
    island_of_block_[i] = kNoIsland;
    if (row.count == 0) continue;
    std::size_t& island = island_of_unit_[leader_of(unit_of(row.sides[0].mover))];
    if (island == kNoIsland) {
      island = islands_.size();
      islands_.push_back({0, 0, 0});
    }
    island_of_block_[i] = island;
    ++(i < active_.size() ? islands_[island].contacts : islands_[island].joints);
  }
  std::size_t first = 0;
  for (Island& island : islands_) {
    island.first_block = first;
    first += island.contacts + island.joints;
    island.contacts = island.joints = 0;
  }
  block_order_.resize(first);
  for (std::size_t i = 0; i < blocks; ++i) {
    if (island_of_block_[i] == kNoIsland) continue;
    Island& island = islands_[island_of_block_[i]];
    block_order_[island.first_block + island.contacts + island.joints] = i;
    ++(i < active_.size() ? island.contacts : island.joints);
  }
}

/// Its rows, one after the other.
void DynamicsWorld::load_rows(const Island& island) {
  local_rows_.clear();
  local_friction_.clear();
  local_bounds_.clear();
  for (std::size_t k = 0; k < island.contacts + island.joints; ++k) {
    const std::size_t block = block_order_[island.first_block + k];
    const bool is_contact = block < active_.size();
    for (std::size_t i = 0; i < (is_contact ? 3U : 1U); ++i) local_rows_.push_back(first_row(block) + i);
    if (is_contact) {
      local_friction_.push_back(friction_[block]);
    } else {
      local_bounds_.push_back(bounds_[block - active_.size()]);
    }
  }
  const std::size_t n = local_rows_.size();
  for (auto* vector : {&local_b_, &local_x_, &local_u_}) vector->resize(n);
  for (std::size_t r = 0; r < n; ++r) {
    local_b_[r] = b_[local_rows_[r]];
    local_x_[r] = x_[local_rows_[r]];
  }
}

/// J M^-1 J^T of the loaded rows: those meet that act on the same body or mechanism, and the rows of one
/// contact all act on the same.
void DynamicsWorld::load_couplings() {
  const std::size_t n = local_rows_.size(), contact_rows = 3 * local_friction_.size();
  W_.assign(n * n, 0.0);
  const auto size_at = [&](std::size_t row) { return row < contact_rows ? 3U : 1U; };
  for (std::size_t r = 0; r < n; r += size_at(r))
    for (std::size_t s = 0; s <= r; s += size_at(s)) {
      if (!meet(rows_[local_rows_[r]], rows_[local_rows_[s]])) continue;
      for (std::size_t i = r; i < r + size_at(r); ++i)
        for (std::size_t k = s; k < s + size_at(s) && k <= i; ++k)
          W_[i * n + k] = W_[k * n + i] = coupling(rows_[local_rows_[i]], rows_[local_rows_[k]]);
    }
}

/// local_u_ = W x + b by way of the units' velocities, without W: what rows cost, not their square. Returns
/// the natural residual.
double DynamicsWorld::velocities_from_impulses() {
  const auto spread_of = [&](const Side& side) { return &spread_[first_of_unit_[unit_of(side.mover)]]; };
  const std::size_t n = local_rows_.size(), contacts = local_friction_.size();
  for (const std::size_t r : local_rows_)
    for (int i = 0; i < rows_[r].count; ++i)
      std::fill_n(spread_of(rows_[r].sides[i]), rows_[r].sides[i].size, 0.0);
  for (std::size_t k = 0; k < n; ++k)
    for (int i = 0; i < rows_[local_rows_[k]].count; ++i) {
      const Side& side = rows_[local_rows_[k]].sides[i];
      double* const spread = spread_of(side);
      for (std::size_t c = 0; c < side.size; ++c) spread[c] += Y_[side.first + c] * local_x_[k];
    }
  double worst = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    double sum = local_b_[k];
    for (int i = 0; i < rows_[local_rows_[k]].count; ++i) {
      const Side& side = rows_[local_rows_[k]].sides[i];
      const double* const spread = spread_of(side);
      for (std::size_t c = 0; c < side.size; ++c) sum += J_[side.first + c] * spread[c];
    }
    local_u_[k] = sum;
  }
  const auto scale = [&](std::size_t k) { return coupling(rows_[local_rows_[k]], rows_[local_rows_[k]]); };
  for (std::size_t c = 0; c < contacts; ++c) {
    const std::size_t k = 3 * c;
    const double w = std::max({scale(k), scale(k + 1), scale(k + 2)});
    if (w > 0.0) worst = std::max(worst, contact_residual(w, local_friction_[c], &local_x_[k], &local_u_[k]));
  }
  for (std::size_t k = 3 * contacts; k < n; ++k) {
    const double w = scale(k);
    if (w > 0.0)
      worst = std::max(worst, w * std::abs(local_x_[k] - clamped(local_x_[k] - local_u_[k] / w,
                                                                 local_bounds_[k - 3 * contacts])));
  }
  return worst;
}

bool DynamicsWorld::meet(const Row& r, const Row& s) const {
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k)
      if (r.sides[i].mover.kind == s.sides[k].mover.kind && r.sides[i].mover.index == s.sides[k].mover.index)
        return true;
  return false;
}

double DynamicsWorld::coupling(const Row& r, const Row& s) const {
  double sum = 0.0;
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k) {
      const Side &a = r.sides[i], &b = s.sides[k];
      if (a.mover.kind != b.mover.kind || a.mover.index != b.mover.index) continue;
      for (std::size_t c = 0; c < a.size; ++c) sum += J_[a.first + c] * Y_[b.first + c];
    }
  return sum;
}

void DynamicsWorld::solve(StepReport& report) {
  u_ = b_;
  find_islands();
  first_of_unit_.clear();
  std::size_t size = 0;
  for (std::size_t i = 0; i < bodies_.size() + mechanisms_.size(); ++i) {
    first_of_unit_.push_back(size);
    size += i < bodies_.size() ? 6 : mechanisms_[i - bodies_.size()].q.size();
  }
  spread_.resize(size);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (rows_[r].count == 0) x_[r] = 0.0;
  for (const Island& island : islands_) {
    load_rows(island);
    SolveReport solved;
    // Most of what rests goes on resting: what held it in the last step does in this.
    solved.residual = velocities_from_impulses();
    if (!(solved.residual <= settings_.solver.tolerance)) {
      load_couplings();
      solved = solver_.solve({island.contacts, local_friction_, local_bounds_, W_, local_b_}, local_x_);
      solved.residual = velocities_from_impulses();
    }
    for (std::size_t k = 0; k < local_rows_.size(); ++k) {
      x_[local_rows_[k]] = local_x_[k];
      u_[local_rows_[k]] = local_u_[k];
    }
    ++report.solves;
    report.unconverged += solved.converged ? 0 : 1;
    report.sweeps += static_cast<std::uint32_t>(solved.sweeps);
    report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
    report.worst_residual = std::max(report.worst_residual, solved.residual);
  }
}

/// Impulses of the rows on each body and mechanism.
void DynamicsWorld::accumulate() {
  for (Body& body : bodies_) body.impulse_W = body.moment_W = Vector3::Zero();
  for (Arm& arm : mechanisms_) std::fill(arm.change.begin(), arm.change.end(), 0.0);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
    const Vector3 moment = cross(point.act_W, impulse);
    const auto act = [&](const Mover& mover, double sign) {
      if (mover.kind != Mover::Kind::body) return;
      bodies_[mover.index].impulse_W += sign * impulse;
      bodies_[mover.index].moment_W += sign * moment;
    };
    act(point.contact.a, -1.0);
    act(point.contact.b, 1.0);
  }
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (int s = 0; s < rows_[r].count; ++s) {
      const Side& side = rows_[r].sides[s];
      if (side.mover.kind != Mover::Kind::link) continue;
      std::vector<double>& change = mechanisms_[side.mover.index].change;
      for (std::size_t k = 0; k < side.size; ++k) change[k] += Y_[side.first + k] * x_[r];
    }
}

// ---- impacts

bool DynamicsWorld::needs_impact() const {
  const double least = 10.0 * settings_.solver.tolerance;  // what a solve leaves is no impact
  for (const Point& point : points_)
    if (point.separation <= settings_.contact_gap &&
        dot(point.contact.n_AB_W, relative_velocity(point)) < -least)
      return true;
  for (const Arm& arm : mechanisms_)
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      if (arm.q[i] - joint.lower <= settings_.contact_gap && arm.qd[i] < -least) return true;
      if (joint.upper - arm.q[i] <= settings_.contact_gap && arm.qd[i] > least) return true;
    }
  return false;
}

void DynamicsWorld::impact(double h, StepReport& report) {
  gather(Phase::impact, 0.0, false);
  solve(report);
  accumulate();
  for (Body& body : bodies_) {
    if (body.is_kinematic) continue;
    body.state.momentum_W += body.impulse_W;
    body.state.angular_W += body.moment_W - cross(body.state.p_W, body.impulse_W);
  }
  for (Arm& arm : mechanisms_) {
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.qd[i] += arm.change[i];
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
    point.impulse_W += impulse;
    point.impact_W += impulse;
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j)
    if (!joint_rows_[j].is_stop)
      mechanisms_[joint_rows_[j].mechanism].torque[joint_rows_[j].value] += x_[3 * active_.size() + j] / h;
}

// ---- forces

/// Without contacts, drives of rows and stops: into the flown states.
bool DynamicsWorld::fly(double t, StepReport& report) {
  const auto fail = [&](StepFailure failure, std::size_t index) {
    report.failure = failure;
    report.failed_index = static_cast<std::uint32_t>(index);
    return false;
  };
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    body.flown = body.state;
    if (body.is_kinematic) {
      body.flown.p_W = body.state.p_W + t * body.v_W;
      body.flown.q_WB = normalized(quaternion_of_turn(t * body.w_W) * body.state.q_WB);
      if (!is_finite(body.flown)) return fail(StepFailure::body, i);
    } else if (!body.body.fly(body.flown, t, settings_.gravity_W)) {
      return fail(StepFailure::body, i);
    }
  }
  for (std::size_t i = 0; i < mechanisms_.size(); ++i) {
    Arm& arm = mechanisms_[i];
    arm.flown_q = arm.q;
    arm.flown_qd = arm.qd;
    for (std::size_t k = 0; k < arm.q.size(); ++k) {
      const JointDrive& drive = arm.drives[k];
      arm.tau[k] = drive.mode == JointDrive::Mode::torque ? cut_torque(drive) : 0.0;
    }
    if (!arm.dynamics->step(arm.X_WBase, settings_.gravity_W, arm.tau, t, arm.flown_q, arm.flown_qd,
                            arm.scratch))
      return fail(StepFailure::mechanism, i);
  }
  return true;
}

/// When sliding first ends or a joint first gets to its drive's rate: forces are at their limits until then,
/// so velocities change evenly, and what the rest of the piece took beside what it could have taken says
/// when.
double DynamicsWorld::first_stop(double t, bool& stops) const {
  const double rest = 10.0 * settings_.solver.tolerance;
  double friction = 0.0, most = 0.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const Point& point = points_[active_[i]];
    const Vector3 before = relative_velocity(point);
    const double slide = std::max(std::abs(dot(before, point.t1_W)), std::abs(dot(before, point.t2_W)));
    const double* const x = &x_[3 * i];
    const double used = std::sqrt(x[1] * x[1] + x[2] * x[2]), cone = friction_[i] * x[0];
    const bool sticks = std::max(std::abs(u_[3 * i + 1]), std::abs(u_[3 * i + 2])) <= rest;
    if (slide <= rest || !sticks || !(cone > 0.0)) continue;
    stops = true;
    friction += used;
    most += cone;
  }
  double first = most > 0.0 ? std::min(1.0, friction / most) : 1.0;
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    const JointRow& row = joint_rows_[j];
    const std::size_t r = 3 * active_.size() + j;
    if (row.is_stop || !(bounds_[j].upper > 0.0) || bounds_[j].upper == kInfinity) continue;
    const JointDrive& drive = mechanisms_[row.mechanism].drives[row.value];
    const double target = drive.mode == JointDrive::Mode::rate ? drive.rate : 0.0;
    const double before = mechanisms_[row.mechanism].qd[row.value] - target;
    if (std::abs(before) <= rest || std::abs(u_[r]) > rest) continue;
    stops = true;
    first = std::min(first, std::abs(x_[r]) / bounds_[j].upper);
  }
  return first * t;
}

void DynamicsWorld::commit(double t, double h) {
  accumulate();
  for (Body& body : bodies_) {
    RigidBodyState& state = body.flown;
    if (!body.is_kinematic && body.impulse_W != Vector3::Zero()) {
      // About the mean of where the body was and is: so that the moment of momentum of all stays.
      state.p_W += (0.5 * t / body.body.inertia().mass) * body.impulse_W;
      const Vector3 twist = body.moment_W - cross(0.5 * (body.state.p_W + state.p_W), body.impulse_W);
      const Vector3 turn = rotate(body.body.inverse_inertia_W(state), (0.5 * t) * twist);
      state.momentum_W += body.impulse_W;
      state.angular_W += twist;
      state.q_WB = normalized(quaternion_of_turn(turn) * state.q_WB);
    }
    body.state = state;
  }
  for (Arm& arm : mechanisms_) {
    for (std::size_t i = 0; i < arm.q.size(); ++i) {
      arm.q[i] = arm.flown_q[i] + (0.5 * t) * arm.change[i];
      arm.qd[i] = arm.flown_qd[i] + arm.change[i];
      arm.torque[i] += arm.tau[i] * (t / h);
    }
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.last_force_W = Vector3::Zero();
  for (std::size_t i = 0; i < active_.size(); ++i) {
    Point& point = points_[active_[i]];
    const Vector3 impulse =
        (x_[3 * i] * point.contact.n_AB_W + x_[3 * i + 1] * point.t1_W) + x_[3 * i + 2] * point.t2_W;
    point.impulse_W += impulse;
    point.last_force_W = impulse / t;
  }
  for (std::size_t j = 0; j < joint_rows_.size(); ++j) {
    if (joint_rows_[j].is_stop) continue;
    Arm& arm = mechanisms_[joint_rows_[j].mechanism];
    const double impulse = x_[3 * active_.size() + j];
    arm.torque[joint_rows_[j].value] += impulse / h;
    arm.last_torque[joint_rows_[j].value] = impulse / t;
  }
}

/// When, in the piece just taken, a point or stop that was apart first came together: on the parabola through
/// its distance and speed before and its distance now. `t` or more: none did.
double DynamicsWorld::first_arrival(double t) const {
  double first = kInfinity;
  const auto arrive = [&](double room, double speed, double room_now) {
    if (room <= settings_.contact_gap || room_now >= -settings_.contact_gap) return;
    const double curve = (room_now - room) / t - speed;  // room + speed s + curve s^2 / t
    const double root = std::sqrt(std::max(0.0, speed * speed - 4.0 * room * curve / t));
    // The first positive root, in the form that does not cancel.
    const double when = 2.0 * room / (root - speed);
    first = std::min(first, when > 0.0 ? std::min(when, t) : t);
  };
  for (const Point& point : points_) arrive(point.start_separation, point.start_speed, point.separation);
  for (const Arm& arm : mechanisms_)
    for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
      const std::uint32_t i = joint.value;
      if (i == Mechanism::kNone) continue;
      arrive(arm.start_q[i] - joint.lower, arm.start_qd[i], arm.q[i] - joint.lower);
      arrive(joint.upper - arm.start_q[i], -arm.start_qd[i], joint.upper - arm.q[i]);
    }
  return first;
}

/// Goes on by at most `left`; returns by how much, 0 on failure.
double DynamicsWorld::piece(double left, double h, bool all, StepReport& report) {
  refresh();
  factor_masses();
  if (needs_impact()) impact(h, report);
  for (Body& body : bodies_) body.start = body.state;
  for (Arm& arm : mechanisms_) arm.start_q = arm.q, arm.start_qd = arm.qd;
  for (Point& point : points_) {
    point.start_separation = point.separation;
    point.start_speed = dot(point.contact.n_AB_W, relative_velocity(point));
    point.start_impulse_W = point.impulse_W;
  }
  for (Arm& arm : mechanisms_) arm.start_torque = arm.torque;
  double t = left;
  int stop_tries = 0;
  for (int attempt = 0;; ++attempt) {
    const bool is_last = all || attempt == kMostTries;
    if (!fly(t, report)) return 0.0;
    gather(Phase::forces, t, is_last);
    solve(report);
    bool stops = false;
    const double stop = first_stop(t, stops);
    if (!is_last && stop < kWhole * t && report.substeps <= kMostStops && stop_tries < kStopTries) {
      ++stop_tries;
      t = stop;
      continue;
    }
    if (stops) report.last_stop = (h - left) + t;
    commit(t, h);
    if (is_last) return t;
    refresh();
    const double arrival = first_arrival(t);
    if (arrival >= t) return t;
    go_back();
    t = arrival;
  }
}

void DynamicsWorld::go_back() {
  for (Body& body : bodies_) body.state = body.start;
  for (Arm& arm : mechanisms_) {
    arm.q = arm.start_q, arm.qd = arm.start_qd, arm.torque = arm.start_torque;
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
  for (Point& point : points_) point.impulse_W = point.start_impulse_W;
  refresh();
}

StepReport DynamicsWorld::step(double h, std::span<const Contact> contacts, std::span<ContactForce> forces) {
  StepReport report;
  if (!check(contacts, report)) return report;
  for (Body& body : bodies_) body.kept = body.state;
  for (Arm& arm : mechanisms_) {
    arm.kept_q = arm.q, arm.kept_qd = arm.qd;
    std::fill(arm.torque.begin(), arm.torque.end(), 0.0);
  }
  attach(contacts);
  double left = h;
  while (left > 0.0) {
    ++report.substeps;
    const double t = piece(left, h, report.substeps >= settings_.most_substeps, report);
    if (report.failure != StepFailure::none) {
      for (Body& body : bodies_) body.state = body.kept;
      for (Arm& arm : mechanisms_) {
        arm.q = arm.kept_q, arm.qd = arm.kept_qd;
        arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
      }
      return report;
    }
    left = t >= left ? 0.0 : left - t;
  }
  finish(h, forces);
  return report;
}

void DynamicsWorld::finish(double h, std::span<ContactForce> forces) {
  warm_.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    warm_.push_back(
        {point.contact.key, point.contact.a, point.contact.b, point.p_A, point.last_force_W, false});
    if (i < forces.size()) forces[i] = {point.impulse_W / h, point.impact_W};
  }
}

}  // namespace touchstone::physics
