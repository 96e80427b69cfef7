#pragma once

#include <cstdint>

namespace touchstone::numerics {

/// The verdict of a filter with an error bound on two closed solids.
enum class Certified : std::uint8_t { separated, overlapping, unknown };

}  // namespace touchstone::numerics
