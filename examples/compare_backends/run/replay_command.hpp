#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

/// The command that replays a case of one of the report's sets, to be pasted into a shell: with the seed of a
/// family, the file of a pair file, the file and parameters of a scene.
/// @param set its name: a family's, the pair file's or a scene's.
std::string replay_command(const Report& report, const std::string& set, const std::string& id);

}  // namespace touchstone::comparison
