#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/numerics/certified.hpp"

namespace touchstone::native {

using numerics::Certified;

/// MPR's portal: three vertices b - a of W = B - A, by their indices in A and B, around the point where a ray
/// leaves W.
struct Portal {
  std::array<std::uint8_t, 3> a{};
  std::array<std::uint8_t, 3> b{};
  bool found = false;
  Vector3 axis = Vector3::Zero();  ///< where the hulls are separated: along which, from A to B, any length
};

/// Minkowski portal refinement, faster than certify_hulls() and with the same two certificates
/// (Snethen, XenoCollide, Game Programming Gems 7, 2008). A ray runs from a point inside W to the origin; a
/// triangle of W's vertices around it moves outwards until the origin lies inside or a plane is found beyond
/// it. Unknown when the origin is near W's boundary or the ray meets an edge; `portal` then is the last
/// triangle, if there was one.
Certified certify_by_mpr(const HullPair& pair, Portal& portal);

}  // namespace touchstone::native
