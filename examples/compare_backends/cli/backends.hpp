#pragma once

#include "touchstone/examples/compare_backends/run/comparison.hpp"

namespace touchstone::comparison {

/// Every backend of this build: those in this process and the worker programs beside `program`; and what is
/// missing.
Backends build_backends(const std::filesystem::path& program);

}  // namespace touchstone::comparison
