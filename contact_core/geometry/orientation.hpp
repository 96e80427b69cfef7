#pragma once

#include <array>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone::numerics {

/// Sign (-1, 0, +1) of det[b - a, c - a, d - a], exact for every finite double input: +1 when d lies on the
/// side that (b-a) x (c-a) points to. No heap, no state: any thread may call at any time.
int orient3d_sign(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) noexcept;

/// True where some four of the points do not lie in one plane; exact, too.
bool has_volume(const std::array<Vector3, 8>& v) noexcept;

}  // namespace touchstone::numerics
