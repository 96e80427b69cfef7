#pragma once

#include <array>
#include <cstdint>

#include "contact_core/geometry/hexahedron.hpp"
#include "contact_core/native/simd/kernels.hpp"

// What the native check keeps of a solid: the faces and edges of the hull of its eight local vertices, found
// once at build.

namespace touchstone::native {

/// Counter-clockwise vertex indices seen from outside, and the outward unit normal in the solid's frame.
struct HullFace {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 8> vertices{};
  Vector3 normal = Vector3::Zero();
};

struct SolidFeatures {
  int face_count = 0;
  std::array<HullFace, 12> faces;
  /// Facet normals and edge directions up to sign and scale, parallel ones once. Not unit: |.| in [1/2, 2].
  int normal_count = 0;
  std::array<Vector3, 12> normals;
  int edge_count = 0;
  std::array<Vector3, 18> edges;
};

/// The hull's features. Supporting planes are found with exact predicates; a plane takes in the vertices that
/// are off it by up to 4 eps * size (and up to a thousandth of the solid's thickness there), so that a face
/// bent by rounding counts as one face. This moves the solid by no more than that, so depths found over these
/// features are off by at most 4 eps * size.
SolidFeatures find_features(const Hexahedron& solid);

/// The same for the kernels.
HullRecord hull_record(const Hexahedron& solid, const SolidFeatures& features);

}  // namespace touchstone::native
