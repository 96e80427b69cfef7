#pragma once

#include <string>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

/// @file
/// Parts of the bundled arms' links, besides round ones (round_parts.hpp).

namespace touchstone {

/// The mass of a solid box along the link's axes, its inertia about its centre.
MassProperties solid_box_mass(double mass, const Vector3& centre_L, const Vector3& size);

/// A square bar between two points, `width` across, that stands out by `beyond` at both ends [m].
/// @pre the points differ.
PlacedHexahedron make_bar(const Vector3& from_L, const Vector3& to_L, double width, double beyond,
                          const std::string& name);
/// The mass of a bar between two points, its inertia about its middle.
MassProperties bar_mass(double mass, const Vector3& from_L, const Vector3& to_L, double width);

}  // namespace touchstone
