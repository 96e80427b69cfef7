#include "touchstone/physics/guarded/cut_impulses.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/physics/solver/cholesky.hpp"

namespace touchstone::physics {
namespace {

/// Sweeps end where none changes a speed by more than this share of the fastest approach.
constexpr double kShareLeft = 0x1p-40;

}  // namespace

CutImpulses::CutImpulses(const SceneSimulation& simulation) : bodies_(simulation.world().body_count()) {
  const std::size_t mechanisms = simulation.scene().mechanisms.size();
  units_.resize(bodies_ + mechanisms);
  held_.assign(units_.size(), 0);
  std::size_t widest = 0, values = 0;
  for (std::size_t m = 0; m < mechanisms; ++m) {
    const MechanismDynamics& dynamics = simulation.dynamics_of(m);
    Unit& unit = units_[bodies_ + m];
    unit.size = dynamics.size();
    unit.first = values;
    unit.placed = dynamics.make_workspace();
    unit.L.resize(unit.size * unit.size);
    values += unit.size;
    widest = std::max(widest, unit.size);
  }
  qd_.resize(values);
  rows_.reserve(kMostContacts);
  J_.reserve(2 * kMostContacts * widest);
  Y_.reserve(2 * kMostContacts * widest);
}

std::uint32_t CutImpulses::unit_of(const SceneSimulation& simulation, const Mover& mover) const {
  std::uint32_t unit = kNoIndex;
  if (mover.kind == Mover::Kind::link) unit = static_cast<std::uint32_t>(bodies_) + mover.index;
  if (mover.kind == Mover::Kind::body && !simulation.world().is_kinematic(mover.index)) unit = mover.index;
  return unit == kNoIndex || held_[unit] ? kNoIndex : unit;
}

void CutImpulses::take_up(const SceneSimulation& simulation, std::uint32_t index) {
  Unit& unit = units_[index];
  if (unit.is_used) return;
  unit.is_used = true;
  const DynamicsWorld& world = simulation.world();
  if (index < bodies_) {
    unit.per_mass = 1.0 / world.body(index).inertia().mass;
    unit.per_inertia_W = world.body(index).inverse_inertia_W(world.state(index));
    unit.v_W = world.velocity(index), unit.w_W = world.angular_velocity(index);
    unit.centre_W = world.state(index).p_W;
    return;
  }
  const auto mechanism = static_cast<std::uint32_t>(index - bodies_);
  const MechanismDynamics& dynamics = simulation.dynamics_of(mechanism);
  const std::span<const double> q = world.joint_values(mechanism), qd = world.joint_rates(mechanism);
  dynamics.place({}, q, qd, unit.placed);
  dynamics.mass_matrix(unit.L, unit.placed);
  if (!factor_cholesky(unit.L, unit.size)) std::fill(unit.L.begin(), unit.L.end(), 0.0);  // stands
  for (std::size_t i = 0; i < unit.size; ++i) qd_[unit.first + i] = qd[i];
}

/// Fills the side's Jacobian; returns the change of the side's speed by a unit impulse [1/kg].
double CutImpulses::per_mass_of(Side& side, const Row& row) const {
  if (side.unit == kNoIndex) return 0.0;
  const Unit& unit = units_[side.unit];
  if (side.unit < bodies_) {
    side.n_W = row.n_W;
    side.turn_W = cross(row.p_W - unit.centre_W, row.n_W);
    return unit.per_mass + dot(side.turn_W, unit.per_inertia_W * side.turn_W);
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < unit.size; ++i) sum += J_[side.first + i] * Y_[side.first + i];
  return sum;
}

void CutImpulses::add(const SceneSimulation& simulation, const Contact& contact) {
  // The row acts along the contact normal, midway between the two points.
  Row row;
  row.n_W = contact.n_AB_W;
  row.p_W = 0.5 * (contact.p_A_W + contact.p_B_W);
  const Mover* movers[2] = {&contact.a, &contact.b};
  double per_mass = 0.0;
  // Each side adds to the row's inverse mass; a commanded side adds its velocity.
  for (const int k : {0, 1}) {
    Side& side = row.sides[k];
    side.sign = k == 0 ? -1.0 : 1.0;
    side.unit = unit_of(simulation, *movers[k]);
    const bool is_commanded = movers[k]->kind == Mover::Kind::body &&
                              simulation.world().is_kinematic(movers[k]->index) && !held_[movers[k]->index];
    if (is_commanded)
      row.commanded += side.sign * dot(row.n_W, simulation.world().velocity_at(*movers[k], row.p_W));
    if (side.unit == kNoIndex) continue;
    take_up(simulation, side.unit);
    // A mechanism has a Jacobian row J and Y = M^-1 J^T.
    if (side.unit >= bodies_) {
      const std::size_t n = units_[side.unit].size;
      const MechanismDynamics& dynamics = simulation.dynamics_of(side.unit - bodies_);
      const bool is_same = k == 1 && row.sides[0].unit == side.unit;  // one mechanism on both sides
      side.first = J_.size();
      J_.resize(J_.size() + n);
      Y_.resize(J_.size());
      const std::span<double> J = std::span(J_).subspan(side.first, n),
                              Y = std::span(Y_).subspan(side.first, n);
      dynamics.point_jacobian(movers[k]->link, row.p_W, row.n_W, J, units_[side.unit].placed);
      if (is_same)
        for (std::size_t i = 0; i < n; ++i) J[i] -= J_[row.sides[0].first + i];
      std::copy(J.begin(), J.end(), Y.begin());
      solve_cholesky(units_[side.unit].L, Y);
      if (is_same) per_mass = 0.0, row.sides[0].unit = kNoIndex;
    }
    per_mass += per_mass_of(side, row);
  }
  // A contact that no impulse moves has no row.
  if (!(per_mass > 0.0)) return;
  row.mass = 1.0 / per_mass;
  row.wanted = contact.restitution;
  rows_.push_back(row);
}

double CutImpulses::speed(const Row& row) const {
  double v = row.commanded;
  for (const Side& side : row.sides) {
    if (side.unit == kNoIndex) continue;
    const Unit& unit = units_[side.unit];
    if (side.unit < bodies_) {
      v += side.sign * (dot(side.n_W, unit.v_W) + dot(side.turn_W, unit.w_W));
      continue;
    }
    for (std::size_t i = 0; i < unit.size; ++i) v += side.sign * J_[side.first + i] * qd_[unit.first + i];
  }
  return v;
}

void CutImpulses::push(const Row& row, double impulse) {
  for (const Side& side : row.sides) {
    if (side.unit == kNoIndex) continue;
    Unit& unit = units_[side.unit];
    const double x = side.sign * impulse;
    if (side.unit < bodies_) {
      unit.v_W += (x * unit.per_mass) * side.n_W;
      unit.w_W += unit.per_inertia_W * (x * side.turn_W);
      continue;
    }
    for (std::size_t i = 0; i < unit.size; ++i) qd_[unit.first + i] += x * Y_[side.first + i];
  }
}

/// To bodies' momenta and mechanisms' rates.
void CutImpulses::give(SceneSimulation& simulation, CutReport& report) {
  DynamicsWorld& world = simulation.world_to_set();
  for (const Row& row : rows_) {
    if (!(row.impulse > 0.0)) continue;
    ++report.contacts;
    Vector3 sum = Vector3::Zero();
    for (const Side& side : row.sides) {
      if (side.unit == kNoIndex || side.unit >= bodies_) continue;
      const Vector3 impulse = (side.sign * row.impulse) * row.n_W;
      sum += impulse;
      RigidBodyState state = world.state(side.unit);
      RigidBody::apply_impulse(state, impulse, row.p_W);
      world.set_state(side.unit, state);
    }
    report.impulse_W += sum;
  }
  for (std::size_t u = bodies_; u < units_.size(); ++u) {
    const Unit& unit = units_[u];
    if (unit.is_used)
      world.set_rates(static_cast<std::uint32_t>(u - bodies_), std::span(qd_).subspan(unit.first, unit.size));
  }
}

CutReport CutImpulses::solve(SceneSimulation& simulation, std::span<const Contact> contacts,
                             double bounce_speed) noexcept {
  CutReport report;
  // Each contact adds a row.
  rows_.clear(), J_.clear(), Y_.clear();
  for (Unit& unit : units_) unit.is_used = false;
  for (const Contact& contact : contacts) {
    if (rows_.size() == kMostContacts) break;
    add(simulation, contact);
  }
  // An approach faster than `bounce_speed` rebounds, a slower one stops.
  for (Row& row : rows_) {
    const double v = speed(row);
    report.approach = std::max(report.approach, -v);
    row.wanted = v < -bounce_speed ? -row.wanted * v : 0.0;
  }
  // Projected Gauss-Seidel sweeps run until the impulses hardly change.
  double change = report.approach;
  for (int sweep = 0; sweep < kMostSweeps && change > kShareLeft * report.approach; ++sweep) {
    change = 0.0;
    for (Row& row : rows_) {
      const double step = std::max(-row.impulse, row.mass * (row.wanted - speed(row)));
      row.impulse += step;
      push(row, step);
      change = std::max(change, std::abs(step) / row.mass);
    }
  }
  // The remaining error is reported, and the impulses are applied.
  for (const Row& row : rows_) report.left = std::max(report.left, row.wanted - speed(row));
  if (report.approach > 0.0) give(simulation, report);
  std::fill(held_.begin(), held_.end(), std::uint8_t{0});
  return report;
}

}  // namespace touchstone::physics
