#pragma once

#include <string>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

/// @file
/// Round parts of links as hexahedra, with the errors of their facets.

namespace touchstone {

/// Hexahedra that stand for a round part. @see append().
struct RoundPart {
  std::vector<PlacedHexahedron> solids;
  std::vector<FacetFigure> figures;  ///< one a circle; `object` is left empty for the link
};

/// A solid cylinder about z from z = 0 to `length`: a prism over a regular polygon cut into facets / 2 - 1
/// slices at right angles to x, `name.0` at +x. Facet 0 is centred on +x. All lengths [m].
/// @param facets even, 4 to 4096. @param inscribed corners on the circle; otherwise the facets touch it.
/// @throws InputError naming `name` and the figure.
RoundPart make_cylinder(double radius, double length, int facets, bool inscribed, const Pose& X_OS,
                        const std::string& name);

/// A tube about z from z = 0 to `length`, one hexahedron a facet. Facet 0 is centred on +x.
/// @param facets 3 to 4096. @param inscribed corners on both circles; otherwise the facets touch both.
/// @throws InputError naming `name` and the figure.
RoundPart make_tube(double outer_radius, double inner_radius, double length, int facets, bool inscribed,
                    const Pose& X_OS, const std::string& name);

/// Adds the part to a link of the description. @pre link < description.links.size()
void append(RoundPart part, std::size_t link, MechanismDescription& description);

/// The largest error of a faceted circle: r (1 - cos(pi/n)) inscribed, r (1 / cos(pi/n) - 1) otherwise [m].
double polygon_error(double radius, int facets, bool inscribed);

}  // namespace touchstone
