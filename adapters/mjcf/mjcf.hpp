#pragma once

#include <filesystem>

#include "touchstone/adapters/robots/robot.hpp"

/// @file
/// Robots from MJCF, compiled by MuJoCo: defaults, includes, frames and inertias are its own. Set-up only:
/// not for several threads at once, as MuJoCo warns through one handler for the process.

namespace touchstone::mjcf {

/// Reads an MJCF file. Bodies become links (`world` the first, which is held), hinges and slides joints, all
/// else a fixed joint; a body with several joints gets links without solids between them, named `body.joint`.
/// Geoms that can touch something (contype or conaffinity) become hexahedra: boxes, spheres, capsules,
/// cylinders, ellipsoids and meshes. Joint values are MuJoCo's less the joint's `ref`. A body's frame is
/// shifted to its joint's anchor. Planes of the world are left out and noted. Exempt are `exclude`d bodies
/// and geoms whose bits do not match. The limits of joints are taken, rates and efforts are not (they belong
/// to actuators). Meshes have MuJoCo's single precision.
/// @throws InputError naming the file and what MuJoCo reports, or body and geom: free and ball joints, planes
/// of bodies and height fields that can touch something, and as the readers of shapes.
Robot load_robot(const std::filesystem::path& file, const RobotOptions& options = {});

}  // namespace touchstone::mjcf
