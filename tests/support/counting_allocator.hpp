#pragma once

#include <cstddef>

namespace touchstone {

/// Calls of operator new, in every form, in this program so far. Counts under the sanitizers too.
std::size_t allocation_count();

}  // namespace touchstone
