#pragma once

#include <span>
#include <string_view>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone::physics {

/// Mass, centre of mass and inertia of a rigid body, in its frame B.
struct BodyInertia {
  double mass = 0.0;                    ///< [kg]
  Vector3 centre_B = Vector3::Zero();   ///< centre of mass [m]
  Matrix3 inertia_B = Matrix3::Zero();  ///< about the centre of mass, in B's axes [kg m2]
};

/// Parts that a body may lack: a thin rod has no inertia about itself, a point none at all.
enum class Thinness : std::uint8_t {
  solid,  ///< every principal moment > 0: free bodies
  thin,   ///< moments may be 0, mass may be 0 with no inertia: links, which turn by their joints
};

/// @throws InputError naming `name` and the figure: a mass that is not finite and positive, a centre that is
/// not finite, an inertia that is not symmetric, has a principal moment that is negative (for `solid`: not
/// positive) or larger than the sum of the other two. The last is what no distribution of mass has: the sum
/// less the largest is twice an integral of a square. Moments are judged to 64 roundings of the largest.
void validate(const BodyInertia& inertia, Thinness thinness, std::string_view name);

/// The inertia of hexahedra of uniform density, exact but for rounding: the convex hull of eight vertices is
/// cut into tetrahedra from a point within, whose second moments are polynomials of their corners; of rounded
/// solids spheres, capsules, rounded boxes and plates have closed forms. Where hexahedra overlap, both count.
/// @param density [kg/m3]. @throws InputError naming `name`: no hexahedron, a density that is not finite and
/// positive, a rounded solid whose core is no box, by its name.
BodyInertia inertia_of_density(std::span<const PlacedHexahedron> solids, double density,
                               std::string_view name);
/// The same for a given total mass [kg].
BodyInertia inertia_of_mass(std::span<const PlacedHexahedron> solids, double mass, std::string_view name);

/// The inertia of a solid box about its centre, sides `size` along B's axes [m].
BodyInertia box_inertia(double mass, const Vector3& size);

/// About the link's centre of mass: the parallel-axis theorem on what the mechanism carries.
/// @throws InputError as validate() for `thin`.
BodyInertia inertia_of(const MassProperties& mass, std::string_view name);

/// B's inertia in frame A.
BodyInertia transform(const Pose& X_AB, const BodyInertia& inertia_B);
/// The inertia of two bodies that move as one, in one frame. One of them may have no mass.
BodyInertia combined(const BodyInertia& a, const BodyInertia& b);
/// Adds `part` to `sum` as combined() does; neither, one or both may have a mass.
void add_inertia(BodyInertia& sum, const BodyInertia& part);

}  // namespace touchstone::physics
