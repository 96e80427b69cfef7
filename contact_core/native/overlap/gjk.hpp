#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

// The Minkowski difference W = B - A of two hulls, searched from its support mapping (Gilbert, Johnson,
// Keerthi 1988; the closest point of a simplex by Voronoi regions, Ericson 2005, section 5.1).

namespace touchstone::native {

using numerics::Certified;

/// Up to four vertices w = b - a of W and the convex combination of them that is nearest the origin.
struct Simplex {
  int count = 0;
  std::array<std::uint8_t, 4> a{};  ///< vertex indices
  std::array<std::uint8_t, 4> b{};
  std::array<Vector3, 4> w;
  std::array<double, 4> weight{};
  Vector3 v = Vector3::Zero();  ///< sum of weight * w
};

/// Whether the hulls of the *world* vertices meet, where floating point can tell. Separated: an axis on which
/// the projections are separated by more than projection_error(). Overlapping: a tetrahedron of vertices of
/// W holds the origin, each of the four determinants beyond its error bound. @param start any vector, best
/// from A to B.
Certified certify_hulls(const HullPair& pair, const Vector3& start);
/// @param axis where separated: that axis, from A to B, any length; else unchanged.
Certified certify_hulls(const HullPair& pair, const Vector3& start, Vector3& axis);

enum class Search : std::uint8_t {
  found,
  lost,    ///< rounding hid it: the origin came to lie inside a simplex, or the iterations ran out
  beyond,  ///< W is certainly further from the origin than the limit
};

/// Finds the point of W nearest the origin, for separated hulls.
/// @param limit give up beyond this distance; may be infinite.
Search closest_point(const HullPair& pair, const Vector3& start, double limit, Simplex& simplex);

/// The point of A (about the pair's origin) with the simplex's weights.
Vector3 point_on_a(const HullPair& pair, const Simplex& simplex);

}  // namespace touchstone::native
