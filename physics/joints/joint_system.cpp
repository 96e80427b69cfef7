#include "touchstone/physics/joints/joint_system.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"
#include "touchstone/physics/solver/cholesky.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"

namespace touchstone::physics {
namespace {

// Errors that are rounding of poses some metres from the origin are left: 2^-44 m, or rad.
constexpr double kSettled = 0x1p-44;
constexpr int kMostPulls = 4;
// A flight is cut into parts in which nothing turns further [rad]: the error of order 6 over one is then
// below 1e-12 of it. No more than kMostParts.
constexpr double kMostTurn = 0.0625;
constexpr int kMostParts = 32;
// By body: place gained, momentum, attitude, angular momentum.
constexpr std::size_t kPlace = 0, kMomentum = 3, kAttitude = 6, kAngular = 10, kBodySize = 13;
constexpr std::size_t kBodyRates = 6;

Vector3 vector_at(const double* y) { return {y[0], y[1], y[2]}; }
void put(const Vector3& v, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = v[i];
}
Quaternion quaternion_at(const double* y) { return {y[0], {y[1], y[2], y[3]}}; }

}  // namespace

void JointSystem::clear() {
  bodies.clear();
  arms.clear();
  kinematic.clear();
  joints.clear();
}

void JointSystem::reserve(std::size_t most_bodies, std::size_t most_arms, std::size_t most_joints,
                          std::size_t widest) {
  // Matrices grow with the square of the rows, so that no more than 64 joints are reserved for.
  const std::size_t rows = BodyJoint::kMostRows * std::min<std::size_t>(most_joints, 64);
  const std::size_t rates = kBodyRates * most_bodies + widest * most_arms;
  const std::size_t size = kBodySize * most_bodies + 2 * widest * most_arms;
  // Bodies, arms and joints enter without allocation.
  bodies.reserve(most_bodies);
  arms.reserve(most_arms);
  kinematic.reserve(2 * most_joints);
  joints.reserve(most_joints);
  placed_.reserve(most_bodies);
  first_rate_.reserve(most_bodies + most_arms);
  M_.resize(std::max(M_.size(), most_arms));
  for (std::vector<double>& M : M_) M.reserve(widest * widest);
  placed_joints_.reserve(most_joints);
  reactions_.reserve(most_joints);
  // So do the equations of their rows.
  rows_.reserve(rows);
  for (auto* vector : {&J_, &Y_}) vector->reserve(2 * std::max(widest, kBodyRates) * rows);
  rest_.reserve(widest);
  equations_.reserve(rows);
  lambda_.reserve(rows);
  // The integrator keeps rates, states and a slope for each stage.
  change_.reserve(rates);
  for (auto& slope : slopes_) slope.reserve(size);
  y_.reserve(2 * size);
  stage_.reserve(std::max(rows, size));
}

std::size_t JointSystem::size_of_unit(std::uint32_t unit) const {
  return unit < bodies.size() ? kBodyRates : arms[unit - bodies.size()].q.size();
}

std::uint32_t JointSystem::unit_of(const Side& side) const {
  if (side.kind == Side::Kind::body) return side.index;
  return side.kind == Side::Kind::arm ? static_cast<std::uint32_t>(bodies.size()) + side.index : kNoIndex;
}

// ---- where things are at a stage

/// The motion of bodies without joints.
void JointSystem::place_bodies(const double* y, const Vector3& gravity_W) {
  placed_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i, y += kBodySize) {
    const Body& body = bodies[i];
    Placed& out = placed_[i];
    RigidBodyState state;
    state.q_WB = normalized(quaternion_at(y + kAttitude));
    const Vector3 L = vector_at(y + kAngular);
    const double mass = body.body->inertia().mass;
    out.R_WB = rotation_matrix(state.q_WB);
    out.inverse_W = body.body->inverse_inertia_W(state);
    out.p_W = body.state.p_W + vector_at(y + kPlace);
    out.v_W = vector_at(y + kMomentum) / mass;
    out.w_W = rotate(out.inverse_W, L);
    out.a_W = gravity_W + body.push_W / mass;
    out.alpha_W = rotate(out.inverse_W, Vector3(body.push_moment_W - cross(out.w_W, L)));
  }
}

/// The same of mechanisms, and their mass matrices.
bool JointSystem::place_arms(const double* y, const Vector3& gravity_W) {
  M_.resize(std::max(M_.size(), arms.size()));
  y += kBodySize * bodies.size();
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const Arm& arm = arms[i];
    const std::size_t n = arm.q.size();
    const std::span<const double> q(y, n), qd(y + n, n);
    arm.dynamics->place(arm.X_WBase, q, qd, *arm.workspace);
    M_[i].resize(n * n);
    rest_.resize(n);  // scratch
    if (!arm.dynamics->forward_dynamics(gravity_W, arm.tau, rest_, *arm.workspace)) return false;
    std::copy(rest_.begin(), rest_.end(), &change_[first_rate_[bodies.size() + i]]);
    arm.dynamics->mass_matrix(M_[i], *arm.workspace);
    if (!factor_cholesky(M_[i], n)) return false;
    y += 2 * n;
  }
  return true;
}

FrameMotion JointSystem::motion_of(const Side& side, double t) const {
  FrameMotion out;
  switch (side.kind) {
    case Side::Kind::ground:
      break;
    case Side::Kind::body: {
      // A body's frame is offset from its centre of mass.
      const Placed& body = placed_[side.index];
      const Vector3 c = rotate(body.R_WB, bodies[side.index].body->inertia().centre_B);
      out = {{body.R_WB, body.p_W - c}, body.v_W - cross(body.w_W, c), body.w_W};
      break;
    }
    case Side::Kind::arm: {
      const Arm& arm = arms[side.index];
      out.X_WM = arm.dynamics->link_pose(side.link, *arm.workspace);
      out.v_W = arm.dynamics->point_velocity(side.link, out.X_WM.p, *arm.workspace);
      out.w_W = arm.dynamics->angular_velocity(side.link, *arm.workspace);
      break;
    }
    case Side::Kind::kinematic: {
      // A kinematic body moves at constant velocities from t = 0.
      const Kinematic& body = kinematic[side.index];
      out = {body.X_WB, body.v_W, body.w_W};
      if (t == 0.0) break;
      out.X_WM.p += t * body.v_W;
      out.X_WM.R = product(rotation_matrix(quaternion_of_turn(t * body.w_W)), body.X_WB.R);
      break;
    }
  }
  return out;
}

Vector3 JointSystem::point_acceleration(const Side& side, const Vector3& p_W, double t) const {
  if (side.kind == Side::Kind::arm) {
    const Arm& arm = arms[side.index];
    return arm.dynamics->point_acceleration(side.link, p_W, gravity_W_, *arm.workspace);
  }
  if (side.kind == Side::Kind::kinematic) {
    const Kinematic& body = kinematic[side.index];
    return cross(body.w_W, cross(body.w_W, Vector3(p_W - (body.X_WB.p + t * body.v_W))));
  }
  if (side.kind == Side::Kind::ground) return Vector3::Zero();
  const Placed& body = placed_[side.index];
  const Vector3 r = p_W - body.p_W;
  return (body.a_W + cross(body.alpha_W, r)) + cross(body.w_W, cross(body.w_W, r));
}

Vector3 JointSystem::turn_acceleration(const Side& side) const {
  if (side.kind == Side::Kind::body) return placed_[side.index].alpha_W;
  if (side.kind != Side::Kind::arm) return Vector3::Zero();
  const Arm& arm = arms[side.index];
  return arm.dynamics->angular_acceleration(side.link, *arm.workspace);
}

// ---- rows

/// One side's part of a row; two links of one mechanism have one part.
void JointSystem::add_side(const Side& side, const BodyJointRow& row, const Vector3& at_W, double sign,
                           JointRow& out) {
  const std::uint32_t unit = unit_of(side);
  if (unit == kNoIndex) return;
  const std::size_t n = size_of_unit(unit);
  // The unit's part of the row is found, or appended.
  int part = 0;
  while (part < out.count && out.units[part] != unit) ++part;
  if (part == out.count) {
    out.units[part] = unit, out.size[part] = n, out.first[part] = J_.size();
    ++out.count;
    J_.resize(J_.size() + n, 0.0);
  }
  // A body's entries are the force and its moment about the centre of mass.
  const Vector3 force = sign * row.force_W, moment = sign * row.moment_W;
  double* const J = &J_[out.first[part]];
  if (unit < bodies.size()) {
    const Vector3 turn = cross(Vector3(at_W - placed_[unit].p_W), force) + moment;
    for (int i = 0; i < 3; ++i) J[i] += force[i], J[i + 3] += turn[i];
    return;
  }
  // A mechanism's entries come from the link's point and rotation Jacobians.
  const Arm& arm = arms[unit - bodies.size()];
  rest_.resize(n);  // scratch
  const auto add = [&] {
    for (std::size_t k = 0; k < n; ++k) J[k] += rest_[k];
  };
  if (row.force_W != Vector3::Zero()) {
    arm.dynamics->point_jacobian(side.link, at_W, force, rest_, *arm.workspace);
    add();
  }
  if (row.moment_W != Vector3::Zero()) {
    arm.dynamics->turn_jacobian(side.link, moment, rest_, *arm.workspace);
    add();
  }
}

/// J and M^-1 J^T of all rows, and their errors: of accelerations, or of place.
void JointSystem::add_rows(double t, bool with_accelerations) {
  rows_.clear();
  J_.clear();
  placed_joints_.resize(joints.size());
  lambda_.clear();  // the rows' errors, for now
  // Each joint is placed by the motion of its two sides.
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const BodyJoint::Placed& placed = placed_joints_[j] =
        joint.joint->place(motion_of(joint.a, t), motion_of(joint.b, t));
    Vector3 a = Vector3::Zero(), alpha = Vector3::Zero();
    if (with_accelerations) {
      a = point_acceleration(joint.b, placed.at_W, t) - point_acceleration(joint.a, placed.at_W, t);
      alpha = turn_acceleration(joint.b) - turn_acceleration(joint.a);
    }
    // Each of its rows gets both sides' Jacobians and its error.
    for (std::size_t i = 0; i < placed.count; ++i) {
      const BodyJointRow& row = placed.rows[i];
      JointRow& out = rows_.emplace_back();
      out.count = 0;
      out.joint = j;
      add_side(joint.a, row, placed.at_W, -1.0, out);
      add_side(joint.b, row, placed.at_W, 1.0, out);
      lambda_.push_back(with_accelerations ? (dot(row.force_W, a) + dot(row.moment_W, alpha)) + row.bias
                                           : row.error);
    }
  }
  // Y = M^-1 J^T is solved unit by unit.
  Y_ = J_;
  for (const JointRow& row : rows_)
    for (int part = 0; part < row.count; ++part) {
      double* const Y = &Y_[row.first[part]];
      const std::uint32_t unit = row.units[part];
      if (unit >= bodies.size()) {
        solve_cholesky(M_[unit - bodies.size()], std::span(Y, row.size[part]));
        continue;
      }
      const double mass = bodies[unit].body->inertia().mass;
      for (int i = 0; i < 3; ++i) Y[i] /= mass;
      put(rotate(placed_[unit].inverse_W, vector_at(Y + 3)), Y + 3);
    }
}

// ---- flight

void JointSystem::start(double* y) const {
  for (const Body& body : bodies) {
    put(Vector3::Zero(), y + kPlace);
    put(body.state.momentum_W, y + kMomentum);
    y[kAttitude] = body.state.q_WB.w;
    put(body.state.q_WB.v, y + kAttitude + 1);
    put(body.state.angular_W, y + kAngular);
    y += kBodySize;
  }
  for (const Arm& arm : arms) {
    y = std::copy(arm.q.begin(), arm.q.end(), y);
    y = std::copy(arm.qd.begin(), arm.qd.end(), y);
  }
}

/// Of y: forces on bodies, accelerations of joints.
void JointSystem::accelerations(double* slope) const {
  for (std::size_t i = 0; i < bodies.size(); ++i, slope += kBodySize) {
    const Body& body = bodies[i];
    const Placed& placed = placed_[i];
    const double* const by_joints = &change_[first_rate_[i]];
    put(placed.v_W, slope + kPlace);
    put((body.push_W + body.body->inertia().mass * gravity_W_) + vector_at(by_joints), slope + kMomentum);
    put(body.push_moment_W + vector_at(by_joints + 3), slope + kAngular);
  }
}

bool JointSystem::slope_at(double t, const double* y, double* slope, const Vector3& gravity_W) {
  // Each unit's rates have a range in `change_`.
  first_rate_.clear();
  std::size_t rates = 0;
  for (std::uint32_t unit = 0; unit < bodies.size() + arms.size(); ++unit) {
    first_rate_.push_back(rates);
    rates += size_of_unit(unit);
  }
  change_.assign(rates, 0.0);
  // The units are placed at this state, and the joints' multipliers are found.
  gravity_W_ = gravity_W;
  place_bodies(y, gravity_W);
  if (!place_arms(y, gravity_W)) return false;  // change_ of arms: without joints
  add_rows(t, true);
  if (!equations_.factor(rows_, J_, Y_)) return false;
  equations_.find_multipliers(lambda_);
  // The multipliers act on bodies as forces, on mechanisms as accelerations.
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (int part = 0; part < rows_[r].count; ++part) {
      const std::uint32_t unit = rows_[r].units[part];
      const std::vector<double>& of = unit < bodies.size() ? J_ : Y_;
      double* const to = &change_[first_rate_[unit]];
      for (std::size_t k = 0; k < rows_[r].size[part]; ++k)
        to[k] += of[rows_[r].first[part] + k] * lambda_[r];
    }
  // Bodies have accelerations, and quaternion rates from their angular velocities.
  accelerations(slope);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double* const q = y + i * kBodySize + kAttitude;
    const Quaternion rate = Quaternion{0.0, 0.5 * placed_[i].w_W} * quaternion_at(q);
    double* const to = slope + i * kBodySize + kAttitude;
    to[0] = rate.w;
    put(rate.v, to + 1);
  }
  // Mechanisms have joint rates and accelerations.
  std::size_t at = kBodySize * bodies.size();
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const std::size_t n = arms[i].q.size();
    const double* const qdd = &change_[first_rate_[bodies.size() + i]];
    for (std::size_t k = 0; k < n; ++k) slope[at + k] = y[at + n + k], slope[at + n + k] = qdd[k];
    at += 2 * n;
  }
  return true;
}

/// Takes the gain over a part of the flight.
bool JointSystem::take(const std::vector<double>& gained, double h) {
  for (const double value : gained)
    if (!std::isfinite(value)) return false;
  const double* d = gained.data();
  for (Body& body : bodies) {
    RigidBodyState& state = body.state;
    add_compensated(state.p_W, state.p_low_W, h * vector_at(d + kPlace));
    add_compensated(state.momentum_W, state.low_W, h * vector_at(d + kMomentum));
    state.angular_W += h * vector_at(d + kAngular);
    const Quaternion dq{h * d[kAttitude], h * vector_at(d + kAttitude + 1)};
    // A turn below the resolution of an attitude is kept back.
    if (norm(dq.v) < 0x1p-54)
      RigidBody::turn_by(state, 2.0 * (dq * conjugate(state.q_WB)).v);
    else
      state.q_WB = normalized({state.q_WB.w + dq.w, Vector3(state.q_WB.v + dq.v)});
    d += kBodySize;
  }
  for (Arm& arm : arms) {
    const std::size_t n = arm.q.size();
    for (std::size_t k = 0; k < n; ++k) arm.q[k] += h * d[k], arm.qd[k] += h * d[n + k];
    d += 2 * n;
  }
  return true;
}

bool JointSystem::fly(double h, const Vector3& gravity_W) {
  // The state vector is sized, and the reactions start at zero.
  std::size_t size = kBodySize * bodies.size();
  for (const Arm& arm : arms) size += 2 * arm.q.size();
  for (auto& slope : slopes_) slope.resize(size);
  reactions_.assign(joints.size(), {Vector3::Zero(), Vector3::Zero()});
  // The flight is divided so that nothing turns too far in one part.
  double fastest = 0.0;
  for (const Body& body : bodies) fastest = std::max(fastest, norm(body.body->angular_velocity(body.state)));
  for (const Arm& arm : arms)
    for (const double rate : arm.qd) fastest = std::max(fastest, std::abs(rate));
  if (!std::isfinite(fastest)) return false;
  const int parts = static_cast<int>(std::min(std::ceil(fastest * h / kMostTurn), double{kMostParts}));
  const double part = h / std::max(parts, 1);
  const RungeKutta& method = kOrder6;
  for (int i = 0; i < std::max(parts, 1); ++i) {
    // Each part starts from the present state.
    y_.resize(2 * size);
    double* const y = y_.data();
    double* const at = y + size;
    start(y);
    // Each Runge-Kutta stage finds the slopes at a weighted state.
    for (std::size_t stage = 0; stage < method.stages; ++stage) {
      double c = 0.0;
      std::copy_n(y, size, at);
      for (std::size_t k = 0; k < stage; ++k) {
        c += method.before[stage][k];
        for (std::size_t n = 0; n < size; ++n) at[n] += part * method.before[stage][k] * slopes_[k][n];
      }
      if (!slope_at(part * (i + c), at, slopes_[stage].data(), gravity_W)) return false;
      // The stage's multipliers add to the reactions of their joints.
      for (std::size_t r = 0; r < rows_.size(); ++r) {
        const std::size_t j = rows_[r].joint;
        std::size_t first = r;
        while (first > 0 && rows_[first - 1].joint == j) --first;
        const BodyJointRow& row = placed_joints_[j].rows[r - first];
        const double impulse = part * method.all[stage] * lambda_[r];
        reactions_[j].impulse_W += impulse * row.force_W;
        reactions_[j].twist_W += impulse * row.moment_W;
      }
    }
    // The weighted slopes advance the state.
    for (std::size_t n = 0; n < size; ++n) {
      double sum = 0.0;
      for (std::size_t k = 0; k < method.stages; ++k) sum += method.all[k] * slopes_[k][n];
      at[n] = sum;
    }
    stage_.assign(at, at + size);
    if (!take(stage_, part)) return false;
  }
  return true;
}

// ---- errors of place

double JointSystem::worst_error() {
  std::size_t size = kBodySize * bodies.size(), rates = 0;
  for (const Arm& arm : arms) size += 2 * arm.q.size();
  first_rate_.clear();
  for (std::uint32_t unit = 0; unit < bodies.size() + arms.size(); ++unit) {
    first_rate_.push_back(rates);
    rates += size_of_unit(unit);
  }
  change_.assign(rates, 0.0);
  y_.resize(2 * size);
  start(y_.data());
  gravity_W_ = Vector3::Zero();
  place_bodies(y_.data(), gravity_W_);
  if (!place_arms(y_.data(), gravity_W_)) return 0.0;
  add_rows(0.0, false);
  double worst = 0.0;
  for (const double error : lambda_) worst = worse_of(worst, std::abs(error));
  return worst;
}

/// By the multipliers lambda_, no row by more than most_correction; returns by how much. A system that
/// nothing holds keeps its angular momentum.
double JointSystem::move_apart(double most_correction) {
  // The multipliers give each unit's displacement.
  std::fill(change_.begin(), change_.end(), 0.0);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (int part = 0; part < rows_[r].count; ++part) {
      double* const to = &change_[first_rate_[rows_[r].units[part]]];
      for (std::size_t k = 0; k < rows_[r].size[part]; ++k)
        to[k] += Y_[rows_[r].first[part] + k] * lambda_[r];
    }
  // The largest displacement of a row limits the scale.
  double farthest = 0.0;
  for (const JointRow& row : rows_) {
    double travel = 0.0;
    for (int part = 0; part < row.count; ++part)
      for (std::size_t k = 0; k < row.size[part]; ++k)
        travel += J_[row.first[part] + k] * change_[first_rate_[row.units[part]] + k];
    farthest = worse_of(farthest, std::abs(travel));
  }
  const double scale = farthest > most_correction ? most_correction / farthest : 1.0;
  for (double& change : change_) change *= scale;
  // A system of free bodies keeps its angular momentum, about its centre of mass.
  const auto is_free = [](const Joint& joint) {
    return joint.a.kind == Side::Kind::body && joint.b.kind == Side::Kind::body;
  };
  const bool all_free = std::all_of(joints.begin(), joints.end(), is_free);
  double mass = 0.0;
  Vector3 momentum = Vector3::Zero();
  for (const Body& body : bodies) {
    mass += body.body->inertia().mass;
    momentum += body.state.momentum_W;
  }
  // Bodies and mechanisms move by the scaled displacements.
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    RigidBodyState& state = bodies[i].state;
    const double* const by = &change_[first_rate_[i]];
    const Vector3 offset = vector_at(by);
    const double body_mass = bodies[i].body->inertia().mass;
    if (all_free) state.angular_W -= cross(offset, Vector3(state.momentum_W - (body_mass / mass) * momentum));
    add_compensated(state.p_W, state.p_low_W, offset);
    RigidBody::turn_by(state, vector_at(by + 3));
  }
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const double* const by = &change_[first_rate_[bodies.size() + i]];
    for (std::size_t k = 0; k < arms[i].q.size(); ++k) arms[i].q[k] += by[k];
  }
  return scale * farthest;
}

double JointSystem::pull_together(double most_correction) {
  double error = worst_error();
  for (int i = 0; i < kMostPulls && error > kSettled; ++i) {
    if (!std::isfinite(error) || !equations_.factor(rows_, J_, Y_)) break;
    equations_.find_multipliers(lambda_);
    most_correction -= move_apart(most_correction);
    const double last = error;
    error = worst_error();
    if (!(error < 0.5 * last) || !(most_correction > 0.0)) break;
  }
  return error;
}

}  // namespace touchstone::physics
