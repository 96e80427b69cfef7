#pragma once

#include <cstdint>

namespace touchstone::native {

/// What a filter with an error bound can say of two closed solids.
enum class Certified : std::uint8_t { separated, overlapping, unknown };

}  // namespace touchstone::native
