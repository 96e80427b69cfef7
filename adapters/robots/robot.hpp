#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

/// @file
/// Shared by the readers of robots (URDF, SDF, MJCF): conversion of shapes to hexahedra, the search for
/// meshes, and the result of a file.

namespace touchstone {

/// Hexahedra that stand for a mesh, in its frame.
struct MeshCover {
  std::vector<PlacedHexahedron> solids;
  double error = 0.0;  ///< no point of them is further than this outside of the mesh's solid [m]
};

/// Turns a mesh in metres into hexahedra that hold it. @param name of the mesh, for messages; the hexahedra's
/// own names are not used. @throws InputError for what it cannot hold.
using CoverMesh = std::function<MeshCover(const TriangleMesh& mesh, const std::string& name)>;

/// The treatment of joints that follow another one.
enum class MimicJoints : std::uint8_t {
  refuse,
  free,  ///< it becomes an independent joint, with a line in Robot::notes
};

/// How a robot's file is read.
struct RobotOptions {
  int cylinder_facets = 12;         ///< even, >= 4; see make_cylinder()
  bool cylinder_inscribed = false;  ///< otherwise the facets touch the cylinder, and the solid holds it
  /// 0: spheres and capsules become rounded solids, exactly; for whoever takes these (native, exact). Else
  /// hexahedra that hold the round shape, with this many facets round and along: a multiple of 4 that is >=
  /// 4, for (n/2 - 1)^2 hexahedra; 8: 16 % of the radius outside, 16: 4 %, 49 hexahedra. See shapes.hpp.
  int sphere_facets = 0;
  int ellipsoid_facets = 8;   ///< the same of ellipsoids, which are never exact
  CoverMesh cover_mesh = {};  ///< such as fitted_cover(); empty: enclosing_box()
  /// Folders that hold packages (or are one), in which `package://` and `model://` are looked for first. Then
  /// those of ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and GAZEBO_MODEL_PATH, and the file's own folders upwards.
  std::vector<std::filesystem::path> package_paths = {};
  MimicJoints mimic = MimicJoints::refuse;
  bool any_mesh_size = false;  ///< meshes of an unlikely size are noted, not refused; see mesh_units.hpp
  bool keep_meshes = false;    ///< Robot::meshes is filled, for pictures
};

/// A shape that is no hexahedron, and what stands for it.
struct ShapeReplacement {
  std::string link;
  std::string name;   ///< of the collision shape in its link
  std::string shape;  ///< mesh, cylinder, sphere, capsule, ellipsoid
  std::string file;   ///< of a mesh; empty otherwise
  std::size_t triangles = 0;
  std::size_t hexahedra = 0;
  double error = 0.0;  ///< the hexahedra's surface is nowhere further from the shape than this [m]
  double size = 0.0;   ///< of a mesh: the diagonal of its box along its axes [m]
};
/// One line.
std::string to_string(const ShapeReplacement& replacement);

/// A mesh where a link has it.
struct LinkMesh {
  std::string link;
  Pose X_LM;
  std::shared_ptr<const TriangleMesh> mesh;  ///< in metres, scaled; links with the same file share it
  std::vector<std::string> hexahedra;        ///< of the link, by name: those that stand for it
};

/// A robot as it was read.
struct Robot {
  MechanismDescription mechanism;
  std::vector<ShapeReplacement> replaced;  ///< in the order of the file's links
  std::vector<std::string> notes;          ///< what a user should know, one line each
  std::vector<LinkMesh> meshes;            ///< what hexahedra stand for; empty unless `keep_meshes`
};

}  // namespace touchstone
