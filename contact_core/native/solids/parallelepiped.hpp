#pragma once

#include <optional>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"

namespace touchstone::native {

inline Vector3 vector_of(const double (&p)[3]) { return {p[0], p[1], p[2]}; }

/// Fits a parallelepiped to a solid's vertices; empty where they are off it by more than 16 eps * size.
std::optional<Parallelepiped> as_parallelepiped(const WorldVertices& vertices_S, double size);

}  // namespace touchstone::native
