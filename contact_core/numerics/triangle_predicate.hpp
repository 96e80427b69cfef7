#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"
#include "touchstone/contact_core/numerics/exact_pair.hpp"

namespace touchstone::numerics {

/// Three vertices b - a of the Minkowski difference W = B - A, by their indices.
struct MinkowskiTriangle {
  std::array<std::uint8_t, 3> a;
  std::array<std::uint8_t, 3> b;

  friend bool operator==(const MinkowskiTriangle&, const MinkowskiTriangle&) = default;
};

/// hulls_intersect() from a good guess: a triangle on W's boundary near the origin. Decides by
/// two certificates, each exact: the origin lies in a tetrahedron on the triangle; or all of W lies beyond
/// the plane of the facets or edges that make the triangle, or touches it there, and then the faces in that
/// plane decide. Any guess is legal; a bad one leaves the verdict unknown.
Certified certify_near(ExactPair& pair, const MinkowskiTriangle& guess) noexcept;

}  // namespace touchstone::numerics
