#pragma once

#include <cstddef>

namespace touchstone {

/// Calls of operator new in this program so far.
std::size_t allocation_count();

}  // namespace touchstone
