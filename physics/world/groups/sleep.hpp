#pragma once

#include <cstdint>
#include <span>

#include "touchstone/physics/world/groups/group_state.hpp"

// Bodies that have come to rest sleep until something comes near.

namespace touchstone::physics::stepping {

/// A kinematic body that was commanded to move.
bool moves(const Body& body);
/// See DynamicsWorld::is_restless().
bool is_restless(const Movers& movers, const Mover& mover);
void count_restless(Movers& movers);
/// A body and all it sleeps with.
void wake(Movers& movers, std::uint32_t body);
void wake_all(Movers& movers);
/// Sleepers that something awake or driven touches.
void wake_touched(Movers& movers, std::span<const Contact> contacts);
/// Bodies alone that nothing commanded touches, none faster than `speed` [m/s], as Settings::sleep_speed.
bool rests(const GroupState& group, double speed, const Movers& movers);
/// Bodies as slow as that along which what is commanded to move slides, as a belt, closing or parting by no
/// more than `closing` [m/s] at any contact. What is carried by it alone does not wait.
bool waits(const GroupState& group, double speed, double closing, const Movers& movers);
/// At the end of the step: all bodies of the group go to sleep, or none.
void count_stillness(const GroupState& group, const StepContext& step, Movers& movers);

}  // namespace touchstone::physics::stepping
