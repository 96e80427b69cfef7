#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "touchstone/tests/proof/pairs/posed_solids.hpp"

namespace touchstone::proof {

/// Enough bytes for any pair; what is missing reads as zero.
inline constexpr std::size_t kDecodedBytes = 256;

/// A pair from bytes, any bytes: boxes, parallelepipeds, frusta, collapsed, warped, sliver and free
/// hexahedra, on small grids or not, jittered by ulps or not; poses that are axis-aligned, nearly so, general
/// or written in single precision; placed anywhere or with two features together; scaled by powers of two and
/// moved far away. The same pair on every compiler (IEEE arithmetic and sqrt only). Nothing when the bytes
/// are no pair of valid solids in valid poses.
std::optional<PosedSolids> decode_pair(std::span<const std::uint8_t> bytes);

/// x to 24 bits.
double in_single_precision(double x);

}  // namespace touchstone::proof
