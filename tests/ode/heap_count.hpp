#pragma once

#include <cstddef>

namespace touchstone::ode_test {

/// Calls of malloc, calloc, realloc and (through malloc) operator new by this process, the engine's included;
/// not counted, and always 0, under a sanitizer, which has these functions itself.
std::size_t heap_calls();
bool counts_heap_calls();

}  // namespace touchstone::ode_test
