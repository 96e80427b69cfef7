#pragma once

#include <cstddef>

namespace touchstone::ode_test {

/// Calls of malloc, calloc, realloc and (through malloc) operator new by this process, the engine's included.
/// Needs glibc without a sanitizer, which has these functions itself.
std::size_t heap_calls();

}  // namespace touchstone::ode_test
