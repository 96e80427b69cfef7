#pragma once

#include <cstdint>
#include <optional>

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"
#include "touchstone/contact_core/numerics/triangle_predicate.hpp"

namespace touchstone::native {

/// Why certify_flush() left a pair open.
enum class FlushMiss : std::uint8_t {
  none,
  plane,     ///< the hulls do not touch this plane from two sides
  rounding,  ///< faces too near to tell: along another plane's normal they may be told
  pair,      ///< edges that cross, vertices exactly in the plane, or magnitudes: no other plane tells more
};

struct FlushVerdict {
  numerics::Certified certified = numerics::Certified::unknown;
  FlushMiss miss = FlushMiss::plane;
  /// Where it is unknown: a triangle in the plane, right but for what scaled heights leave open.
  std::optional<numerics::MinkowskiTriangle> guess = std::nullopt;
};

/// Whether two hulls meet that touch, but for rounding, in a common plane: boxes that lie flush in a turned
/// frame. Their vertices there are off the plane by an ulp or so; measured along the plane's normal in twice
/// the precision and scaled up, these heights make an ordinary pair, which certify_hulls() decides.
/// @param a_W, b_W finite world vertices.
/// @param n_AB of the plane, any length, right to a few u; a bad guess leaves the verdict unknown.
/// @param p_W on the plane, but for rounding.
/// @returns unknown where nothing is certain: among others where the vertices near the plane are exactly on
/// it.
FlushVerdict certify_flush(const Kernels& kernels, const WorldVertices& a_W, const WorldVertices& b_W,
                           const Vector3& n_AB, const Vector3& p_W);

}  // namespace touchstone::native
