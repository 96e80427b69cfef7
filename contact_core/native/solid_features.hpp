#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

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

/// The hull's features, found with exact predicates.
///
/// Normals and edges are those of the exact hull, whose facets count as one where their normals agree to 16
/// u: depths found over them are off by at most 32 u of the pair's size (derived in the source). Faces, for
/// manifolds, are wider: a plane takes in the vertices that are off it by up to 4 eps * size (and up to a
/// thousandth of the solid's thickness there), so that a face bent by rounding counts as one face.
/// @param record the same hull for the kernels, or null.
SolidFeatures find_features(const Hexahedron& solid, HullRecord* record = nullptr);

}  // namespace touchstone::native
