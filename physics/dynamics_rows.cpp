// Rows of the contact problem: one a direction of a contact, a drive, an end stop.

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/cholesky.hpp"
#include "physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

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

}  // namespace touchstone::physics
