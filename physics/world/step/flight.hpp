#pragma once

#include "touchstone/physics/world/rows/contact_rows.hpp"

// A piece of a step: free flight, then the changes that impulses make to it.

namespace touchstone::physics::stepping {

/// Prepares flights of any length from the group's state. @return false: the step fails.
bool begin_flight(const Group& group, StepContext& step, Movers& movers);
/// Without contacts and rows: to Body::flown, Arm::flown_q and flown_qd. @return false: the step fails.
/// @param t length of the piece [s] @pre begin_flight()
bool fly(const Group& group, double t, StepContext& step, Movers& movers);
/// Contacts' impulses over a piece of length t [s] are what the next solve starts from.
void keep_forces(double t, const ContactRows& rows, GroupState& group);
/// The piece of length t [s] ends in the flown states and what the rows' impulses make of them.
void commit(double t, const StepContext& step, GroupState& group, Movers& movers, ContactRows& rows);
/// An impulse of a joint between movers, among what it did in the step. @param t of the piece it acted over;
/// 0: of an impact. @param h the step
void take_joint_impulse(HeldJoint& held, const ContactRows::Joint& row, double impulse, double t, double h);
/// Bodies that touch nothing, over the whole step, under gravity and pushes. @return false: the step fails.
bool fly_loose(std::span<const std::uint32_t> bodies, StepContext& step, Movers& movers);

}  // namespace touchstone::physics::stepping
