#pragma once

#include "contact_core/native/box_box_overlap.hpp"
#include "contact_core/native/hull_pair.hpp"

namespace touchstone::native {

/// The quick first half of certify_hulls(), with the same two certificates: Minkowski portal refinement
/// (Snethen, XenoCollide, Game Programming Gems 7, 2008). A ray runs from a point inside W = B - A to the
/// origin; a triangle of W's vertices around it moves outwards until the origin lies inside or a plane is
/// found beyond it. Unknown when the origin is near W's boundary, or the ray meets an edge.
Certified certify_by_portal(const HullPair& pair);

}  // namespace touchstone::native
