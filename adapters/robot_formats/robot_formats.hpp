#pragma once

#include <filesystem>
#include <vector>

#include "touchstone/adapters/robots/robot.hpp"

/// @file
/// Robots by their file's extension, of the formats that a build reads.

namespace touchstone {

/// .urdf, .sdf, .xml or .mjcf, in any case. @throws nothing
bool is_robot_file(const std::filesystem::path& file);

/// The reader of the file's extension. @throws InputError: another extension, a format that this build does
/// not read, and as the readers.
Robot load_robot(const std::filesystem::path& file, const RobotOptions& options = {});

/// The pairs that an SRDF file disables. @throws InputError where this build reads none, and as
/// urdf::load_srdf().
std::vector<ExemptPair> load_exempt_pairs(const std::filesystem::path& srdf);

}  // namespace touchstone
