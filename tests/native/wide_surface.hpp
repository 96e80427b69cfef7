#pragma once

#include <array>
#include <vector>

#include "contact_core/geometry/hexahedron.hpp"

namespace touchstone {

// Slivers lose as many bits as their sides' ratio has: 64-bit mantissas tell nothing of sides of 1 and 1e-12.
#if defined(__SIZEOF_FLOAT128__)
__extension__ using Wide = __float128;
#else
using Wide = long double;
#endif

/// The surface of the convex hull of eight world vertices, with 113-bit mantissas where the machine has them.
class WideSurface {
 public:
  explicit WideSurface(const WorldVertices& solid);
  /// True when the hull has no volume; distance() may not be used then.
  bool is_flat() const { return triangles_.empty(); }
  /// From p to the surface, from inside too [m].
  double distance(const Vector3& p) const;

 private:
  std::vector<std::array<Vector3, 3>> triangles_;
};

}  // namespace touchstone
