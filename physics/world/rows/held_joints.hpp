#pragma once

#include "touchstone/physics/world/groups/group_state.hpp"
#include "touchstone/physics/world/groups/step_context.hpp"
#include "touchstone/physics/world/rows/contact_rows.hpp"

// Joints between movers during a step.

namespace touchstone::physics::stepping {

/// By Movers::update_motions().
FrameMotion motion_now(const Mover& mover, const Movers& movers);
/// At the end of a flight of t [s] from there. @pre fly_jointed()
FrameMotion motion_flown(const Mover& mover, const Movers& movers, double t);

/// Marks what the group's joints hold: Body::is_jointed, Arm::is_jointed.
void mark_jointed(const Group& group, Movers& movers);
/// Values and rates of the joints at the start of a piece. Returns the largest velocity that a joint does not
/// allow [m/s], [rad/s].
double refresh_joints(const Group& group, Movers& movers);
/// Whether a joint at its end moves into it faster than `least`.
bool meets_end(const Group& group, const Movers& movers, double gap, double least);
/// All that the group's joints hold, to the flown states. @return false: the step fails.
bool fly_jointed(const Group& group, double t, StepContext& step, Movers& movers);
/// The value of a hinge or slider from Movers::update_motions(); its turns are counted from its value at the
/// start of the piece.
double value_now(const HeldJoint& joint, const Movers& movers);
/// After the step: errors of place are taken back, turns counted.
void finish_joints(const Group& group, StepContext& step, Movers& movers);

}  // namespace touchstone::physics::stepping
