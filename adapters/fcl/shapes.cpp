#include "touchstone/adapters/fcl/shapes.hpp"

#include <vector>

namespace touchstone::fcl_adapter {

Shape make_box(const Hexahedron& solid) { return std::make_shared<fcl::Boxd>(2.0 * solid.half_extents()); }

Shape make_convex(const Hexahedron& solid) {
  auto faces = std::make_shared<std::vector<int>>();
  for (const auto& quad : Hexahedron::kFaceVertices) {
    faces->push_back(4);
    faces->insert(faces->end(), quad.begin(), quad.end());
  }
  auto vertices =
      std::make_shared<std::vector<fcl::Vector3d>>(solid.vertices().begin(), solid.vertices().end());
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(Hexahedron::kFaceVertices.size()), faces);
}

fcl::Transform3d to_engine(const Pose& X) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = X.R;
  out.translation() = X.p;
  return out;
}

}  // namespace touchstone::fcl_adapter
