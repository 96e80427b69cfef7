#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/adapters/robots/robot.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

/// @file
/// Arms from URDF (parsed by urdfdom) and which of their links are not checked from SRDF. Set-up only: not
/// for several threads at once, as urdfdom reports through one handler for the process.

namespace touchstone::urdf {

/// How shapes become hexahedra, where `package://` is looked for, and what becomes of mimic joints.
using LoadOptions = RobotOptions;

/// Reads a URDF file's `<collision>` elements; `<visual>` is not read. Boxes become hexahedra, cylinders
/// prisms, spheres and meshes hexahedra that hold them; Robot::replaced states their errors, those of round
/// parts in facet_figures too. Meshes are in metres with axes as written, as other readers of URDF have them;
/// DAE states its own unit. Solids without a name, or whose name the link has already, are named
/// `collision.0`, `collision.1`, ... by their place in the link. Links and joints come from the root
/// outwards, depth first, a link's joints by name: that is the order of the joint values. Axes are
/// normalised. `continuous` joints are revolute without limits. The reference pose is the value nearest to 0
/// within each joint's limits. The inertia is about the centre of mass, turned into the link's axes.
/// @throws InputError naming the file and what urdfdom reports, or the link or joint: floating and planar
/// joints, mimic joints unless the options free them, meshes that are not there or malformed (load_mesh()),
/// and all that Mechanism rejects in data (see there; it checks the tree itself).
Robot load_robot(const std::filesystem::path& file, const RobotOptions& options = {});
/// @param source stands in messages for the file's name; meshes with relative names are looked for beside it.
Robot parse_robot(const std::string& xml, const std::string& source = "urdf",
                  const RobotOptions& options = {});

/// load_robot() without its account.
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
