#pragma once

#include <span>

#include "touchstone/examples/measures/truth/oracle.hpp"
#include "touchstone/examples/training_run/flight/flight_log.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {

/// Flies the script: hands to commands, commands to the method, what is shown to its outputs, frame by frame.
/// @param in_real_time frames begin no sooner than by the clock on the wall.
/// @throws InputError: an arm that does not fit, an action that is refused.
FlightLog fly(const Setting& setting, Method& method, bool in_real_time,
              const measures::Progress& progress = {});

}  // namespace touchstone::training
