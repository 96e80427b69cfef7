// Rows of the contact problem: one a direction of a contact, a drive, an end stop.

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/physics/cholesky.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// What a step's work counts for a point that is flown to, and whose rows are gathered.
constexpr double kPointWork = 500.0;

}  // namespace

void DynamicsWorld::factor_masses() {
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    arm.dynamics->mass_matrix(arm.M, arm.placed);
    factor_cholesky(arm.M, arm.q.size());
  }
}

Vector3 DynamicsWorld::impulse_of(std::size_t contact) const {
  const Point& point = points_[active_[contact]];
  const double* const x = &x_[3 * contact];
  return (x[0] * point.contact->n_AB_W + x[1] * point.t1_W) + x[2] * point.t2_W;
}

/// Velocities before impulses, at the start of an impact or after free flight. Forces act over the piece:
/// about the middle of a body's way, and turn it as it stands at the end.
void DynamicsWorld::prepare_bodies(Phase phase) {
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    const RigidBodyState& state = phase == Phase::forces ? body.flown : body.state;
    body.middle_W = 0.5 * (body.state.p_W + state.p_W);
    body.row_v_W = body.body.velocity(state);
    body.row_inverse_W = body.body.inverse_inertia_W(state);
    body.row_w_W = rotate(body.row_inverse_W, state.angular_W);
    if (phase == Phase::parting) body.row_v_W = body.row_w_W = Vector3::Zero();
  }
}

/// Takes the side up. Returns a body's velocity at the point; a mechanism's goes to b, by its rows.
Vector3 DynamicsWorld::add_side(Side& side, const Mover& mover, const Point& point, Phase phase, double* b) {
  side.unit = unit_of(mover);
  if (side.unit == kNone)
    return mover.kind == Mover::Kind::body && phase != Phase::parting ? point_velocity(mover, point.p_W)
                                                                      : Vector3(Vector3::Zero());
  if (is_body(side.unit)) {
    const Body& body = bodies_[side.unit];
    side.lever_W = point.act_W - body.middle_W;
    return body.row_v_W + cross(body.row_w_W, side.lever_W);
  }
  const Arm& arm = arm_of(side.unit);
  const std::vector<double>& rates = phase == Phase::forces ? arm.flown_qd : arm.qd;
  const std::size_t n = rates.size();
  const Vector3 directions[3] = {point.contact->n_AB_W, point.t1_W, point.t2_W};
  if (!has_rows_) {
    side.first = J_.size();
    J_.resize(J_.size() + 3 * n);
    Y_.resize(J_.size());
    for (std::size_t r = 0; r < 3; ++r) {
      const std::span<double> J = std::span(J_).subspan(side.first + r * n, n),
                              Y = std::span(Y_).subspan(side.first + r * n, n);
      arm.dynamics->point_jacobian(mover.link, point.p_W, side.sign * directions[r], J, arm.placed);
      std::copy(J.begin(), J.end(), Y.begin());
      solve_cholesky(arm.M, Y);
    }
  }
  for (std::size_t r = 0; r < 3 && phase != Phase::parting; ++r)
    for (std::size_t k = 0; k < n; ++k) b[r] += J_[side.first + r * n + k] * rates[k];
  return Vector3::Zero();
}

void DynamicsWorld::add_contact(std::size_t index, Phase phase, double t) {
  Point& point = points_[index];
  const Contact& contact = *point.contact;
  // The point goes along with what touches there, half with each.
  point.act_W = point.p_W;
  if (phase == Phase::forces) point.act_W += (0.5 * t) * point.mean_v_W;
  double b[3] = {0.0, 0.0, 0.0};
  point.sides[0].sign = -1.0, point.sides[1].sign = 1.0;
  const Vector3 v_A = add_side(point.sides[0], contact.a, point, phase, b);
  const Vector3 v_B = add_side(point.sides[1], contact.b, point, phase, b);
  const Vector3 v = v_B - v_A;
  const Vector3 directions[3] = {contact.n_AB_W, point.t1_W, point.t2_W};
  for (int i = 0; i < 3; ++i) {
    b[i] += dot(directions[i], v);
    x_.push_back(phase == Phase::forces ? t * dot(directions[i], point.last_force_W) : 0.0);
  }
  if (phase == Phase::parting)
    b[0] = (point.separation + allowed_depth(point)) / t;
  else if (phase == Phase::impact)
    b[0] *= b[0] < -settings_.bounce_speed ? 1.0 + contact.restitution : 1.0;
  else if (point.separation > settings_.contact_gap)
    b[0] += point.separation / t;
  b_.insert(b_.end(), b, b + 3);
  friction_.push_back(contact.friction);
  if (!has_rows_) active_.push_back(index);
}

void DynamicsWorld::add_joint_row(const JointRow& joint, double b, ContactProblem::Bounds bounds,
                                  double warm) {
  const Arm& arm = mechanisms_[joint.mechanism];
  const std::size_t n = arm.q.size();
  b_.push_back(b);
  x_.push_back(warm);
  bounds_.push_back(bounds);
  if (has_rows_) return;
  joint_rows_.push_back(joint);
  joint_rows_.back().first = J_.size();
  J_.resize(J_.size() + n, 0.0);
  Y_.resize(J_.size(), 0.0);
  const std::size_t own = joint_rows_.back().first + joint.value;
  J_[own] = Y_[own] = joint.sign;
  solve_cholesky(arm.M, std::span(Y_).subspan(joint_rows_.back().first, n));
}

void DynamicsWorld::add_joint_rows(std::uint32_t mechanism, Phase phase, double t, bool all) {
  const Arm& arm = mechanisms_[mechanism];
  for (const Mechanism::Joint& joint : arm.dynamics->mechanism().joints()) {
    const std::uint32_t i = joint.value;
    if (i == Mechanism::kNone) continue;
    const JointDrive& drive = arm.drives[i];
    const bool parts = phase == Phase::parting;  // then drives hold
    const double rate = parts ? 0.0 : phase == Phase::impact ? arm.qd[i] : arm.flown_qd[i];
    // In no time only a drive of unlimited torque gives an impulse.
    if (drive.mode != JointDrive::Mode::torque && (phase != Phase::impact || drive.limit == kInfinity)) {
      const double target = drive.mode == JointDrive::Mode::rate && !parts ? drive.rate : 0.0;
      const double most = parts || drive.limit == kInfinity ? kInfinity : drive.limit * t;
      add_joint_row({mechanism, i, 1.0, false, 0}, rate - target, {-most, most},
                    parts ? 0.0 : t * arm.last_torque[i]);
    }
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0.0 ? joint.lower : joint.upper;
      const double room = sign * (arm.q[i] - limit);
      const bool is_open = !(room <= settings_.contact_gap);
      if (std::isinf(limit) || (is_open && !all)) continue;
      add_joint_row({mechanism, i, sign, true, 0}, sign * rate + (is_open ? room / t : 0.0), {0.0, kInfinity},
                    0.0);
    }
  }
}

/// @param all points and stops that are apart, too: they may be approached as far as they are.
/// @param anew or the rows are those gathered last, in a piece of another length from the same start.
void DynamicsWorld::gather(Phase phase, double t, bool all, bool anew) {
  has_rows_ = !anew;
  if (anew) {
    active_.clear();
    joint_rows_.clear();
    for (auto* vector : {&J_, &Y_}) vector->clear();
  }
  for (auto* vector : {&b_, &x_, &friction_}) vector->clear();
  bounds_.clear();
  prepare_bodies(phase);
  budget_.spend(kPointWork * static_cast<double>(points_.size()));
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (all || points_[i].separation <= settings_.contact_gap) add_contact(i, phase, t);
  for (const std::uint32_t m : group_.mechanisms) add_joint_rows(m, phase, t, all);
}

}  // namespace touchstone::physics
