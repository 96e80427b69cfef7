#pragma once

#include <cstdint>

namespace touchstone {

/// In place of an index of 32 bits: there is none. No list is as long.
inline constexpr std::uint32_t kNoIndex = 0xffffffff;

}  // namespace touchstone
