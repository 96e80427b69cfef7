#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/native/common/certified.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {

/// Three vertices b - a of W = B - A, by their indices in A and B: where a ray leaves W.
struct Portal {
  std::array<std::uint8_t, 3> a{};
  std::array<std::uint8_t, 3> b{};
  bool found = false;
};

/// The quick first half of certify_hulls(), with the same two certificates: Minkowski portal refinement
/// (Snethen, XenoCollide, Game Programming Gems 7, 2008). A ray runs from a point inside W to the origin; a
/// triangle of W's vertices around it moves outwards until the origin lies inside or a plane is found beyond
/// it. Unknown when the origin is near W's boundary, or the ray meets an edge: then the triangle it came to
/// is `portal`, if it got that far.
Certified certify_by_portal(const HullPair& pair, Portal& portal);

}  // namespace touchstone::native
