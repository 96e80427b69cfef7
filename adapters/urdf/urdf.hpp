#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

/// @file
/// Arms from URDF (parsed by urdfdom) and which of their links are not checked from SRDF. Set-up only: not
/// for several threads at once, as urdfdom reports through one handler for the process.

namespace touchstone::urdf {

/// How URDF's cylinders become hexahedra.
struct LoadOptions {
  int cylinder_facets = 12;         ///< even, >= 4; see make_cylinder()
  bool cylinder_inscribed = false;  ///< otherwise the facets touch the cylinder, and the solid holds it
};

/// Reads a URDF file's `<collision>` elements; `<visual>` is not read. Boxes become hexahedra,
/// cylinders prisms, their facets' error in facet_figures. Solids without a name, or whose name the link has
/// already, are named `collision.0`, `collision.1`, ... by their place in the link. Links and joints come
/// from the root outwards, depth first, a link's joints by name: that is the order of the joint values. Axes
/// are normalised. `continuous` joints are revolute without limits. The reference pose is the value nearest
/// to 0 within each joint's limits. The inertia is about the centre of mass, turned into the link's axes.
/// @throws InputError naming the file and what urdfdom reports, or the link or joint: floating, planar and
/// mimic joints, spheres and meshes (not hexahedra), and all that Mechanism rejects in data (see there; it
/// checks the tree itself).
MechanismDescription load_urdf(const std::filesystem::path& file, const LoadOptions& options = {});
/// @param source stands in messages for the file's name.
MechanismDescription parse_urdf(const std::string& xml, const std::string& source = "urdf",
                                const LoadOptions& options = {});

/// The `<disable_collisions>` entries of an SRDF file, for MechanismDescription::exempt_pairs. Nothing else
/// of it is read; names are checked by Mechanism.
/// @throws InputError naming the file and line: no XML, no `<robot>`, an entry without link1 or link2, and
/// the elements that change which entries count, `<disable_default_collisions>` and `<enable_collisions>`.
std::vector<ExemptPair> load_srdf(const std::filesystem::path& file);
/// @param source stands in messages for the file's name. @throws InputError as load_srdf().
std::vector<ExemptPair> parse_srdf(const std::string& xml, const std::string& source = "srdf");

}  // namespace touchstone::urdf
