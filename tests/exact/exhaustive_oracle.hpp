#pragma once

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::exact_test {

/// True if `separation` is the signed distance of the two hulls correctly rounded. By exhaustion, sharing no
/// code with the backend: the signed distance is the largest of h(n)/|n| over all directions n, reached at a
/// closest-feature or facet direction; all vertex pairs count as edges and all triples as faces, everything
/// in rational arithmetic.
bool is_signed_distance(const WorldVertices& a, const WorldVertices& b, double separation);

}  // namespace touchstone::exact_test
