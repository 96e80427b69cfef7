#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>

#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/adapters/robots/robot.hpp"

// For the readers of robots.

namespace touchstone {

/// Where a shape goes.
struct ShapePlace {
  std::size_t link;   ///< index in the description
  std::string name;   ///< in the link; made unique with `.2`, `.3`, ... where it is taken
  std::string label;  ///< in messages: file, link and shape
  Pose X_LS;          ///< its frame in the link
};

/// Adds shapes to a robot's links as hexahedra, and keeps account of what was replaced.
class RobotBuilder {
 public:
  /// Both must outlive it. @param source the robot's file, or what stands for its name.
  RobotBuilder(Robot& robot, const RobotOptions& options, std::filesystem::path source)
      : robot_(&robot), options_(&options), source_(std::move(source)) {}

  /// @return the link's index.
  std::size_t add_link(const std::string& name);
  /// All throw InputError that begins with the place's label. Shapes are centred on their frame, the axis of
  /// round ones is z; `size` are full sides, `length` of a capsule is that of its segment.
  void add_box(const ShapePlace& place, const Vector3& size);
  void add_cylinder(const ShapePlace& place, double radius, double length);
  void add_sphere(const ShapePlace& place, double radius);
  void add_capsule(const ShapePlace& place, double radius, double length);
  void add_ellipsoid(const ShapePlace& place, const Vector3& half_axes);
  /// @param uri a path relative to the robot's file, or package://, model://, file://.
  /// @param scale of the mesh's axes; one below 0 mirrors.
  void add_mesh_file(const ShapePlace& place, const std::string& uri, const Vector3& scale);
  /// @param file stands in the report.
  void add_mesh(const ShapePlace& place, TriangleMesh mesh, const std::string& file);

 private:
  struct Loaded {
    MeshCover cover;
    std::size_t triangles;
    double size;                               ///< [m]
    std::shared_ptr<const TriangleMesh> mesh;  ///< null unless kept
  };

  std::string unique_name(std::size_t link, const std::string& wanted);
  void add_rounded(const ShapePlace& place, const char* shape, const Hexahedron& solid);
  template <class Make>
  void add_round(const ShapePlace& place, const char* shape, const Make& make);
  Loaded load(const std::filesystem::path& file, const Vector3& scale);
  void add_cover(const ShapePlace& place, const Loaded& loaded, const std::string& file);
  /// @param name of the mesh, for messages.
  Loaded made_of(TriangleMesh mesh, const std::string& name) const;

  Robot* robot_;
  const RobotOptions* options_;
  std::filesystem::path source_;
  std::map<std::size_t, std::set<std::string>> names_;                        // by link
  std::map<std::tuple<std::string, double, double, double>, Loaded> loaded_;  // by file and scale
};

}  // namespace touchstone
