#pragma once

#include <array>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

/// @file
/// The planes of a hexahedron's faces, from its corners in the order of Hexahedron.

namespace touchstone {

using Corners = std::array<Vector3, Hexahedron::kVertices>;

/// Through the centroid of face 0-5, normal across its diagonals; a zero normal where they are parallel.
Plane face_plane(const Corners& corners, int face);

/// How far the face is bent: the largest distance of its corners from that plane.
double face_bend(const Corners& corners, int face);

/// The largest of the six.
double largest_bend(const Corners& corners);

}  // namespace touchstone
