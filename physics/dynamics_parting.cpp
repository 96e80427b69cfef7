// Overlap is taken back at a step's end by moving what overlaps, not by impulses: it parts without momentum.

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/compensated_sum.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

// Of the fastest parting: moved so much too little, it is still on its way.
constexpr double kShareOfParting = 1e-2;
// What parts does so at least this fast [m/s]: the last of it would else take part in step after step.
constexpr double kLeastSpeed = 1e-3;
// Of the contact gap: less overlap than this is left, or parting would stir what rests.
constexpr double kLeftAlone = 1e5;
// Newton's, of a step: what they leave is left to the next.
constexpr int kMostSteps = 6;

}  // namespace

/// At the end of the step: what was there at its start, less what parts in it; what it made anew is not.
double DynamicsWorld::allowed_depth(const Point& point) const {
  const double depth = point.first_depth;
  if (settings_.push_out == 0.0) return std::max(settings_.contact_gap, depth);
  const double speed = std::min(std::max(settings_.push_out * depth, kLeastSpeed), settings_.part_speed);
  return std::max(settings_.contact_gap, depth - speed * h_);
}

/// Where something is deeper than allowed, and than what is left alone.
bool DynamicsWorld::needs_parting() const {
  const double gap = settings_.contact_gap;
  return std::any_of(points_.begin(), points_.end(), [&](const Point& point) {
    return -separation_now(point) > std::max(allowed_depth(point) + gap, kLeftAlone * gap);
  });
}

/// Whether nothing holds the group: its momenta are its own.
bool DynamicsWorld::is_free_group() const {
  return group_.mechanisms.empty() && std::all_of(points_.begin(), points_.end(), [&](const Point& point) {
           return unit_of(point.contact->a) != kNone && unit_of(point.contact->b) != kNone;
         });
}

/// The least motion, weighed by mass, that leaves no more depth than is allowed, against friction: the
/// contact problem once more, in velocities that last for the step alone.
void DynamicsWorld::part(double h, StepReport& report) {
  place_kinematics(h);
  update_motions();
  if (!needs_parting()) return;
  refresh();
  factor_masses();
  gather(Phase::parting, h, true, true);
  u_ = b_;
  find_islands();
  const std::size_t mechanism_rows = J_.size();
  double fastest = 0.0;
  for (const double b : b_) fastest = std::max(fastest, -b);
  const double tolerance = std::max(settings_.contact_gap / h, kShareOfParting * fastest);
  WorkBudget budget = budget_of(points_.size());  // velocities may have taken all of the step's
  for (const Island& island : islands_) {
    if (update_velocities(island).worst <= tolerance) continue;
    load_island(island);
    load_convex(island);
    const SparseContacts problem{
        convex_sizes_, masses_, island.contacts, local_friction_, local_bounds_, convex_rows_, J_, Y_,
        local_b_};
    report.newton_steps += static_cast<std::uint32_t>(
        convex_.solve_softly(problem, local_x_, tolerance, budget, kMostSteps).newton_steps);
    for (std::size_t k = 0; k < local_rows_.size(); ++k) x_[local_rows_[k]] = local_x_[k];
    J_.resize(mechanism_rows);
    Y_.resize(mechanism_rows);
  }
  move_apart(h);
}

/// A free group's moment of momentum stays: what moves a body off its path is taken from its turning, in the
/// frame of the group's centre.
void DynamicsWorld::move_apart(double h) {
  accumulate();
  const bool is_free = is_free_group();
  double mass = 0.0;
  Vector3 momentum = Vector3::Zero();
  for (const std::uint32_t i : group_.bodies) {
    mass += bodies_[i].body.inertia().mass;
    momentum += bodies_[i].state.momentum_W;
  }
  for (const std::uint32_t i : group_.bodies) {
    Body& body = bodies_[i];
    if (body.impulse_W == Vector3::Zero() && body.moment_W == Vector3::Zero()) continue;
    const double own = body.body.inertia().mass;
    const Vector3 way = (h / own) * body.impulse_W;
    if (is_free) body.state.angular_W -= cross(way, Vector3(body.state.momentum_W - (own / mass) * momentum));
    add_compensated(body.state.p_W, body.state.p_low_W, way);
    RigidBody::turn_by(body.state, rotate(body.row_inverse_W, Vector3(h * body.moment_W)));
  }
  for (const std::uint32_t m : group_.mechanisms) {
    Arm& arm = mechanisms_[m];
    for (std::size_t i = 0; i < arm.q.size(); ++i) arm.q[i] += h * arm.change[i];
    arm.dynamics->place(arm.X_WBase, arm.q, arm.qd, arm.placed);
  }
}

}  // namespace touchstone::physics
