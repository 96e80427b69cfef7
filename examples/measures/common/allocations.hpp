#pragma once

#include <cstdint>
#include <optional>

namespace touchstone::measures {

/// Heap allocations (malloc, calloc, realloc, aligned_alloc, posix_memalign; operator new goes through
/// malloc) made so far by the calling thread, in every library of the process. Empty where they cannot be
/// counted: under a sanitizer, or without glibc.
std::optional<std::uint64_t> thread_allocations() noexcept;

}  // namespace touchstone::measures
