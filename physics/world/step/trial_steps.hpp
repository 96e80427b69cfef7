#pragma once

#include "touchstone/physics/world/dynamics_world.hpp"

// Steps of a world of no one, so that the first ones of others do not wait for the program's code.

namespace touchstone::physics::stepping {

/// Takes steps of two small cubes that overlap, slide and fall: all methods of islands of few contacts come
/// from where the program lies into the processor's caches. Allocates. @return why the first step that was
/// not taken was not: none, that is.
StepFailure take_trial_steps();

}  // namespace touchstone::physics::stepping
