#pragma once

#include "touchstone/contact_core/numerics/vertex_hull.hpp"

namespace touchstone::numerics {

/// True if the Minkowski difference {b - a} has no volume: both hulls then lie in parallel planes (lines,
/// points).
bool span_no_volume(DifferenceDeterminant& determinant, const VertexHull& a, const VertexHull& b) noexcept;

/// hulls_intersect() for such hulls. @pre span_no_volume()
bool flat_hulls_intersect(DifferenceDeterminant& determinant, const VertexHull& a,
                          const VertexHull& b) noexcept;

}  // namespace touchstone::numerics
