#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/world/groups/contact_groups.hpp"
#include "touchstone/physics/world/groups/step_context.hpp"
#include "touchstone/physics/world/groups/warm_start.hpp"

// The contact points of the group that is being stepped.

namespace touchstone::physics::stepping {

/// A contact during the step.
struct GroupPoint {
  const Contact* contact;
  std::uint32_t index;            // of the contact
  Vector3 p_A, p_B;               // in the movers' frames
  Vector3 p_W;                    // between the points, at the start of the piece
  Vector3 v_W;                    // of B's point seen from A's, there
  Vector3 path_v_W;               // of the place where they touch, there
  Vector3 t1_W, t2_W;             // at right angles to the normal
  double separation, approach_v;  // at the start of the piece; the speed after its impact
  double allowed_depth;           // at the end of the step
  Vector3 impulse_W, start_impulse_W, impact_W, last_force_W;  // on B
  Vector3 parting_W;                                           // ContactMemory
};

/// A group and the state of its contacts.
struct GroupState {
  Group members;
  std::vector<std::uint32_t> kinematics;  // that its contacts touch
  std::vector<GroupPoint> points;
  std::vector<GroupPoint> spare;  // that take no part in the step: see keep_fewest()
  double joint_speed = 0.0;       // the largest that a joint does not allow, at the start of the piece
  bool is_coarse = false;         // it goes through the step in one piece
};

/// Takes up the group's contacts, as they are at the start of the step.
void attach(const Group& group, std::span<const Contact> contacts, const WarmStart& warm,
            const StepContext& step, Movers& movers, GroupState& state);
/// Where the points are now, the normal kept as it was; and update_speeds().
void refresh(const Movers& movers, GroupState& state);
/// Velocities of the points, by Movers::update_motions().
void update_speeds(const Movers& movers, GroupState& state);
/// By Movers::update_motions() [m].
double separation_now(const GroupPoint& point, const Movers& movers);
/// Poses and velocities of all that points are on.
void update_motions(const GroupState& state, Movers& movers);

}  // namespace touchstone::physics::stepping
