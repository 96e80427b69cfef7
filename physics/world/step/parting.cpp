#include "touchstone/physics/world/step/parting.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"

namespace touchstone::physics::stepping {
namespace {

// Of the contact gap: less overlap than this is left, or parting would stir what rests.
constexpr double kLeftAlone = 1e5;
// How long the parting of what is_deep() takes [s]. A tenth makes 5 mm of the usual speed: what arrives
// within a step of a group in one piece comes less deep. Heaps that no table shows (`other:` in
// dynamics_scenes_benchmark) come to rest alike with 2 and 10 mm, and worse with 0.1.
constexpr double kDeep = 0.1;

bool needs_parting(const GroupState& group, const Movers& movers, double gap) {
  return std::any_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
    return -separation_now(point, movers) > std::max(point.allowed_depth + gap, kLeftAlone * gap);
  });
}

/// Whether overlap that is parted is deeper than `most` [m] anywhere, where the step begins.
bool is_deeper(const GroupState& group, const DynamicsWorld::Settings& settings, double most) {
  return settings.push_out > 0.0 &&
         std::any_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
           const Contact& contact = *point.contact;
           return -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W) > most;
         });
}

/// Whether nothing outside holds the group, so that its momenta are conserved.
bool is_free(const GroupState& group, const Movers& movers) {
  return group.members.mechanisms.empty() &&
         std::all_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
           return movers.unit_of(point.contact->a) != kNoUnit && movers.unit_of(point.contact->b) != kNoUnit;
         });
}

/// Turns the free group as one body, so that it has this angular momentum more: of all changes of its
/// momenta that do, the one of least energy.
void turn_together(const Group& members, const Vector3& moment, Movers& movers) {
  double mass = 0.0;
  Vector3 middle_W = Vector3::Zero();
  for (const std::uint32_t i : members.bodies) {
    const Body& body = movers.bodies[i];
    mass += body.body.inertia().mass;
    middle_W += body.body.inertia().mass * body.state.p_W;
  }
  middle_W = middle_W / mass;
  Matrix3 inertia = Matrix3::Zero();
  for (const std::uint32_t i : members.bodies) {
    const Body& body = movers.bodies[i];
    const Matrix3 lever = skew(Vector3(body.state.p_W - middle_W));
    inertia += symmetric_inverse(body.body.inverse_inertia_W(body.state));
    inertia -= body.body.inertia().mass * product(lever, lever);
  }
  const Vector3 w_W = rotate(symmetric_inverse(inertia), moment);
  for (const std::uint32_t i : members.bodies) {
    Body& body = movers.bodies[i];
    const Vector3 lever = body.state.p_W - middle_W;
    add_compensated(body.state.momentum_W, body.state.low_W, body.body.inertia().mass * cross(w_W, lever));
    body.state.angular_W += rotate(symmetric_inverse(body.body.inverse_inertia_W(body.state)), w_W);
  }
}

/// Turns the body where it stands. Its angular momentum stays, unless it would turn with more energy then.
void turn_aside(const Vector3& angles_W, Body& body) {
  const auto spin_energy = [&body] {
    return 0.5 * dot(body.state.angular_W, body.body.angular_velocity(body.state));
  };
  const double before = spin_energy();
  RigidBody::turn_by(body.state, angles_W);
  const double after = spin_energy();
  if (after > before) body.state.angular_W *= std::sqrt(before / after);
}

/// By velocities that last for h. A free group's angular momentum stays: displacements off the bodies' paths
/// are taken from the group's turning, in the frame of its centre.
void move_apart(const GroupState& group, double h, Movers& movers, ContactRows& rows) {
  sum_impulses(rows);
  // The group's mass and momentum give the velocity of its centre.
  double mass = 0.0;
  Vector3 momentum = Vector3::Zero(), given = Vector3::Zero();
  for (const std::uint32_t i : group.members.bodies) {
    mass += movers.bodies[i].body.inertia().mass;
    momentum += movers.bodies[i].state.momentum_W;
  }
  // Each body is displaced, and the angular momentum that this gives is summed up.
  for (const std::uint32_t i : group.members.bodies) {
    const RowUnit& unit = rows.units[i];
    if (unit.impulse_W == Vector3::Zero() && unit.moment_W == Vector3::Zero()) continue;
    Body& body = movers.bodies[i];
    const double body_mass = body.body.inertia().mass;
    const Vector3 displacement = (h / body_mass) * unit.impulse_W, turning = body.state.angular_W;
    given += cross(displacement, Vector3(body.state.momentum_W - (body_mass / mass) * momentum));
    add_compensated(body.state.p_W, body.state.p_low_W, displacement);
    turn_aside(rotate(unit.inverse_inertia_W, Vector3(h * unit.moment_W)), body);
    given += body.state.angular_W - turning;
  }
  // The rotation of a free group takes that angular momentum back.
  if (given != Vector3::Zero() && is_free(group, movers)) turn_together(group.members, -given, movers);
  // Mechanisms are displaced by their joints' changes.
  for (const std::uint32_t m : group.members.mechanisms) {
    Arm& arm = movers.arms[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.q[i] += h * arm.change[i];
    arm.place();
  }
}

}  // namespace

bool is_deep(const GroupState& group, const DynamicsWorld::Settings& settings) {
  return is_deeper(group, settings, std::max(kDeep * settings.part_speed, kLeftAlone * settings.contact_gap));
}

bool overlaps(const GroupState& group, const DynamicsWorld::Settings& settings) {
  return is_deeper(group, settings, kLeftAlone * settings.contact_gap);
}

void part(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver) {
  const double gap = step.settings.contact_gap, h = step.h;
  movers.place_kinematics(group.kinematics, h);
  update_motions(group, movers);
  if (!needs_parting(group, movers, gap)) {
    for (GroupPoint& point : group.points) point.parting_W = Vector3::Zero();
    return;
  }
  refresh(movers, group);
  factor_masses(group.members, movers);
  gather({Phase::parting, h, true, true}, group, step, movers, rows);
  double fastest = 0.0;
  for (const double b : rows.b) fastest = std::max(fastest, -b);
  const double tolerance = std::max(gap / h, kShareOfParting * fastest);
  // Its budget is separate: velocities may have spent all of the step's.
  WorkBudget budget = step.budget;
  budget.grant(work_of(group.members, movers, step));
  solver.solve_softly(rows, tolerance, budget, step.report);
  for (std::size_t i = 0; i < rows.contacts.size(); ++i)
    group.points[rows.contacts[i].point].parting_W = rows.impulse_of(i);
  move_apart(group, h, movers, rows);
}

}  // namespace touchstone::physics::stepping
