#pragma once

#include "touchstone/adapters/robots/robot.hpp"

namespace touchstone {

/// How far the joints' frames reach from the base at most: the longest chain's offsets added up [m].
double joint_reach(const MechanismDescription& mechanism);

/// Compares the meshes' sizes with how far the joints reach. A robot whose largest mesh is 30 times as
/// large, or a 300th, has another unit in its meshes than in its file; from 10 times and a 30th on a note
/// says so.
/// @param source the robot's file, for messages. @throws InputError naming the mesh, its link and the factor,
/// unless options.any_mesh_size. Robots without meshes or without distances between joints pass.
void check_mesh_units(const std::string& source, const RobotOptions& options, Robot& robot);

}  // namespace touchstone
