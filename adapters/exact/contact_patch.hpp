#pragma once

#include <array>
#include <span>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// The overlap of two faces, seen along a normal. Computed in doubles: good to about 1e-15 of the solids'
/// size.
struct ContactPatch {
  static constexpr int kMaxVertices = 8;  ///< two quadrilaterals clipped

  int face_a = 0, face_b = 0;  ///< indices into Hexahedron::kFaceVertices
  int vertex_count = 0;
  /// p_A_W on A's face, p_B_W on B's, over each other along the normal; separation along it, which may be
  /// above 0.
  std::array<ContactPoint, kMaxVertices> vertices;
  double area = 0.0;  ///< of the vertices' hull, projected along the normal [m^2]
};

/// The clip of A's face most parallel to n_AB_W and B's most antiparallel to it, projected along n_AB_W.
/// Faces are the six quadrilaterals of Hexahedron::kFaceVertices with these world vertices; a bent one counts
/// as its two outer triangles.
/// @pre both lists are in Hexahedron's order (world_vertices()); n_AB_W is a unit vector.
ContactPatch find_contact_patch(const WorldVertices& a, const WorldVertices& b, const Vector3& n_AB_W);

/// Largest error of the heights of a clip's vertices [m].
double patch_rounding(const WorldVertices& a, const WorldVertices& b);

/// The patch of narrowphase.hpp: the clip's vertices that are no further apart than `limit` [m], and the area
/// of their hull.
ContactPatch part_within(const ContactPatch& clip, const Vector3& n_AB_W, double limit);

/// Picks at most max_points of the patch into `out`: the deepest, then those that make the largest area.
/// @returns how many.
int select_contact_points(const ContactPatch& patch, const Vector3& n_AB_W, std::span<ContactPoint> out);

}  // namespace touchstone
