#pragma once

#include <optional>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// The direction that most area faces, up to sign, among those across `across` (zero: any). Zero: of no area.
Vector3 main_direction(const TriangleMesh& mesh, const Vector3& across);

/// A turned part's frame: rows are the orthonormal axes that most of the mesh's area faces, where that is
/// much more than faces the coordinates' axes. None where the mesh stands along these, or along nothing.
std::optional<Matrix3> turned_frame(const TriangleMesh& mesh);

}  // namespace touchstone::fit
