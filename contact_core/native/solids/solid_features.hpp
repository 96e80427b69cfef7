#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

// The features that the native check keeps of a solid: the faces and edges of the hull of its eight local
// vertices, found once at build.

namespace touchstone::native {

/// Counter-clockwise vertex indices seen from outside, and the outward unit normal in the solid's frame.
struct HullFace {
  static constexpr std::int8_t kPlane = -1;

  std::uint8_t count = 0;
  std::array<std::uint8_t, 8> vertices{};
  std::int8_t bend = kPlane;  ///< of a bent face: index into SolidFeatures::bends
  Vector3 normal = Vector3::Zero();
};

/// The two triangles of the hull that make up a bent face of four vertices, and the ridge between them.
struct Bend {
  std::uint8_t ridge = 0;  ///< from vertex `ridge` of the face's loop, 0 or 1, to vertex ridge + 2
  std::array<Vector3, 2>
      normals;  ///< outward, unit: of the triangle right of the ridge, (0 1 2) or (1 2 3); left
};

struct SolidFeatures {
  int face_count = 0;
  std::array<HullFace, 12> faces;
  /// Facet normals and edge directions up to sign and scale, parallel ones once. Not unit: |.| in [1/2, 2].
  int normal_count = 0;
  std::array<Vector3, 12> normals;
  int edge_count = 0;
  std::array<Vector3, 18> edges;
  int bend_count = 0;
  std::array<Bend, 6> bends;
  QuadFaces quads{};  ///< the faces again, for the kernels
};

/// The hull's features, found with exact predicates.
///
/// Normals and edges are those of the exact hull, whose facets count as one where their normals agree to 16
/// u: depths found over them are off by at most 32 u of the pair's size (derived in the source). Faces, for
/// manifolds, are wider: a plane takes in the vertices that are off it by up to 4 eps * size (and up to a
/// thousandth of the solid's thickness there). Of what is bent more than that, the two triangles of one of
/// the user's faces (Hexahedron::kFaceVertices) are one bent face where their normals' cosine is at least
/// kManifoldCosine; its normal is that of its area vector (across its diagonals). All other facets are faces
/// of their own.
/// @param record the same hull for the kernels, or null.
SolidFeatures find_features(const Hexahedron& solid, HullRecord* record = nullptr);

/// The faces for the kernels, where they are the six that the solid's vertices have in its own order, all
/// plane.
PlainHull plain_hull(const SolidFeatures& features, const HullRecord& record);

}  // namespace touchstone::native
