#pragma once

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>

#include <memory>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

// Solids and poses as FCL takes them.

namespace touchstone::fcl_adapter {

using Shape = std::shared_ptr<fcl::CollisionGeometryd>;

/// @pre it is a box.
Shape make_box(const Hexahedron& solid);
/// The six quads as faces.
Shape make_convex(const Hexahedron& solid);
inline Shape make_shape(const Hexahedron& solid) {
  return solid.is_box() ? make_box(solid) : make_convex(solid);
}

fcl::Transform3d to_engine(const Pose& X);

}  // namespace touchstone::fcl_adapter
