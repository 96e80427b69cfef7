#include "touchstone/physics/world/step/parting.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/bodies/compensated_sum.hpp"

namespace touchstone::physics::stepping {
namespace {

// Of the fastest parting: moved so much too little, it is still on its way.
constexpr double kShareOfParting = 1e-2;
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

/// Whether nothing holds the group: its momenta are its own.
bool is_free(const GroupState& group, const Movers& movers) {
  return group.members.mechanisms.empty() &&
         std::all_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
           return movers.unit_of(point.contact->a) != kNoUnit && movers.unit_of(point.contact->b) != kNoUnit;
         });
}

/// By velocities that last for h. A free group's moment of momentum stays: what moves a body off its path is
/// taken from its turning, in the frame of the group's centre.
void move_apart(const GroupState& group, double h, Movers& movers, ContactRows& rows) {
  sum_impulses(rows);
  const bool is_group_free = is_free(group, movers);
  double mass = 0.0;
  Vector3 momentum = Vector3::Zero();
  for (const std::uint32_t i : group.members.bodies) {
    mass += movers.bodies[i].body.inertia().mass;
    momentum += movers.bodies[i].state.momentum_W;
  }
  for (const std::uint32_t i : group.members.bodies) {
    const RowUnit& unit = rows.units[i];
    if (unit.impulse_W == Vector3::Zero() && unit.moment_W == Vector3::Zero()) continue;
    Body& body = movers.bodies[i];
    const double own = body.body.inertia().mass;
    const Vector3 way = (h / own) * unit.impulse_W;
    if (is_group_free)
      body.state.angular_W -= cross(way, Vector3(body.state.momentum_W - (own / mass) * momentum));
    add_compensated(body.state.p_W, body.state.p_low_W, way);
    RigidBody::turn_by(body.state, rotate(unit.inverse_inertia_W, Vector3(h * unit.moment_W)));
  }
  for (const std::uint32_t m : group.members.mechanisms) {
    Arm& arm = movers.arms[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.q[i] += h * arm.change[i];
    arm.place();
  }
}

}  // namespace

bool is_deep(const GroupState& group, const DynamicsWorld::Settings& settings) {
  const double deep = std::max(kDeep * settings.part_speed, kLeftAlone * settings.contact_gap);
  return settings.push_out > 0.0 &&
         std::any_of(group.points.begin(), group.points.end(), [&](const GroupPoint& point) {
           const Contact& contact = *point.contact;
           return -dot(contact.n_AB_W, contact.p_B_W - contact.p_A_W) > deep;
         });
}

void part(GroupState& group, StepContext& step, Movers& movers, ContactRows& rows, IslandSolver& solver) {
  const double gap = step.settings.contact_gap, h = step.h;
  movers.place_kinematics(group.kinematics, h);
  update_motions(group, movers);
  if (!needs_parting(group, movers, gap)) return;
  refresh(movers, group);
  factor_masses(group.members, movers);
  gather({Phase::parting, h, true, true}, group, step, movers, rows);
  double fastest = 0.0;
  for (const double b : rows.b) fastest = std::max(fastest, -b);
  const double tolerance = std::max(gap / h, kShareOfParting * fastest);
  // Its own work: velocities may have taken all of the step's.
  WorkBudget budget = step.budget;
  budget.grant(work_of(group.members, movers, step.settings));
  solver.solve_softly(rows, tolerance, budget, step.report);
  move_apart(group, h, movers, rows);
}

}  // namespace touchstone::physics::stepping
