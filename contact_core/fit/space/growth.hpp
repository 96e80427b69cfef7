#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/space/allowed_space.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// Outward normals of the six faces, in their order.
using Normals = std::array<Vector3, 6>;

/// Of a box with these axes, orthonormal.
Normals box_normals(const Vector3& x, const Vector3& y, const Vector3& z);

/// The largest share of a change in (0, 1] that is allowed, 0 for none: what is allowed of a growing solid is
/// allowed of all before it.
template <class Try>
double largest_share(const Try& is_allowed) {
  constexpr double kFinest = 1.0 / 64.0;
  if (is_allowed(1.0)) return 1.0;
  double low = 0.0, high = 1.0;
  while (high - low > kFinest) {
    const double middle = 0.5 * (low + high);
    (is_allowed(middle) ? low : high) = middle;
  }
  return low;
}

/// Grows hexahedra in a space: a face goes outwards as far as that lets it.
class Growth {
 public:
  /// @param resolution a face stops within this of the limit [m]
  Growth(const MeshDistance& mesh, AllowedSpace& space, double resolution)
      : mesh_(mesh), space_(space), resolution_(resolution) {}

  /// Moves the faces outwards in the order given, each as far as it goes, until none moves.
  void push(SixPlanes& solid, std::span<const int> faces);
  /// Turns faces outwards about each of their edges, as far as they go.
  void tilt(SixPlanes& solid);
  bool allows(const SixPlanes& solid) { return solid.is_hexahedron() && space_.allows(solid); }

 private:
  double reach(const Plane& plane) const;
  /// Whether the corners alone are what they have to be, those of the face that has moved.
  bool has_good_corners(const SixPlanes& solid, int face) const;
  bool push_face(SixPlanes& solid, int face);
  bool tilt_face(SixPlanes& solid, int face, int edge);

  const MeshDistance& mesh_;
  AllowedSpace& space_;
  double resolution_;
};

}  // namespace touchstone::fit
