#pragma once

#include <span>

#include "examples/measures/oracle.hpp"
#include "examples/training_run/flight_log.hpp"
#include "examples/training_run/recording.hpp"
#include "examples/training_run/way.hpp"

namespace touchstone::training {

/// Flies the script: hands to commands, commands to the way, what is shown to the outputs, frame by frame.
/// @throws InputError: an arm that does not fit, an action that is refused.
FlightLog fly(const Setting& setting, Way& way, std::span<FrameOutput* const> outputs,
              const comparison::Progress& progress = {});

}  // namespace touchstone::training
