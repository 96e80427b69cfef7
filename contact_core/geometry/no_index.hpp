#pragma once

#include <cstdint>

namespace touchstone {

/// Stands for "none" where a 32-bit index is expected. No list is that long.
inline constexpr std::uint32_t kNoIndex = 0xffffffff;

}  // namespace touchstone
