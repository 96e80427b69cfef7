#pragma once

#include <filesystem>
#include <string>
#include <vector>

// For the readers of robots.

namespace touchstone {

/// Where a mesh (or a file that SDF includes) that a robot's file names is: `package://NAME/PATH` and
/// `model://NAME/PATH` in the folder of that package, `file:///PATH`, `/PATH`, or a path relative to the
/// robot's folder (by `..` it may go anywhere), or, where it has none, to one above it up to that with a
/// package.xml. A folder is package NAME if it is called so or its package.xml says so; looked in, in this
/// order: `package_paths` and what is in them, those of ROS_PACKAGE_PATH, GAZEBO_MODEL_PATH and
/// AMENT_PREFIX_PATH (each with /share), the robot's folder and those above it. Where nothing has the name as
/// a URI writes it, `%20` and the like are decoded.
/// @throws InputError naming the mesh: no such package or file, a `package://` or `model://` name that leaves
/// its package (by its words: links in the file system are followed), another scheme.
std::filesystem::path mesh_path(const std::string& uri, const std::filesystem::path& robot,
                                const std::vector<std::filesystem::path>& package_paths);

}  // namespace touchstone
