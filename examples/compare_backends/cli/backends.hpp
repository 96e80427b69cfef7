#pragma once

#include "touchstone/examples/compare_backends/run/comparison.hpp"

namespace touchstone::comparison {

/// The path of a worker program of `program`: beside it in a build folder; not among users' commands where it
/// is installed.
std::filesystem::path worker_beside(const std::filesystem::path& program, const char* name);

/// Every backend of this build: those in this process and the worker programs beside `program`; and what is
/// missing.
Backends build_backends(const std::filesystem::path& program);

}  // namespace touchstone::comparison
