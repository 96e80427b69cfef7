#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone::training {

/// Joint values to begin a flight of a link with, the best first: robot_files::start_values() alone where the
/// hand is regular there (ResolvedRate::regularity() at least `damped_below`), else after bent poses that are
/// at least twice as far from a singularity, the farthest first. Those are drawn, always the same ones, from
/// the middle half of each joint's range, a quarter of a turn beside the middle at most; joints that do not
/// move the link stay.
/// @pre a joint moves the link.
std::vector<std::vector<double>> starts_of(const Mechanism& robot, std::uint32_t link);

}  // namespace touchstone::training
