#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/comparison.hpp"

namespace touchstone::comparison {

/// Adds the backends of shared libraries (c_interface/touchstone_plugin.h), each asked in a worker process
/// beside `program`: where one dies or hangs, its answers are `failed` and the report says how.
/// @throws InputError naming the library: it cannot be loaded, or its backend's name is taken.
void add_plugins(Backends& backends, const std::filesystem::path& program,
                 const std::vector<std::string>& libraries, std::chrono::milliseconds time_limit);

/// Adds engines as processes (adapters/process_engine) by their commands, words between blanks.
/// @param time_limit none: the adapter's own.
/// @throws InputError naming the command: it is no engine, its name is taken, this build has none.
void add_engines(Backends& backends, const std::vector<std::string>& commands,
                 std::optional<std::chrono::milliseconds> time_limit);

}  // namespace touchstone::comparison
