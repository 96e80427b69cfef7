#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/adapters/robot_formats/robot_formats.hpp"

// Robots of others in programs: which formats this build reads, and their options.

namespace CLI {
class App;  // its header costs each file that includes it seconds
}

namespace touchstone::robot_files {

/// The command line's options for robots.
struct RobotChoices {
  std::vector<std::string> files;          ///< --robot
  std::vector<std::string> package_paths;  ///< --package-path
  std::string srdf;                        ///< --srdf: of all robots; empty: none
  /// --over: error of what covers a mesh, a length, a share of the mesh's size, or "box": one box each
  std::string over = "5%";
  std::string covers_folder;   ///< --covers: keeps covers from run to run; empty: none
  bool any_mesh_size = false;  ///< --any-mesh-size, as RobotOptions has it
  int sphere_facets = 0;       ///< --sphere-facets, as RobotOptions has it
  bool keep_meshes = false;    ///< for pictures, as RobotOptions has it
  /// Covers of this run: copies share them, so that no mesh is fitted twice.
  std::shared_ptr<CoverMesh> covers = std::make_shared<CoverMesh>();
};
void add_robot_options(CLI::App& app, RobotChoices& choices);

/// Reads a robot; once their units are looked at its meshes are covered within `over`, with progress on
/// stderr, and where the build has adapters/cover_proof each cover is proven, those from earlier runs as
/// well. Links that overlap in the reference pose are exempt, and named in its notes. @throws InputError: a
/// format that this build does not read, an invalid `over`, a cover that is not proven, and as the
/// readers.
Robot load_robot_file(const std::filesystem::path& file, const RobotChoices& choices);

/// The replacements, their errors and other notes for a user, a line each; may be empty.
std::string account_of(const Robot& robot);

/// Joint values in the middle of their limits where they have some, away from stretched poses and from stops;
/// else the reference's.
std::vector<double> start_values(const Mechanism& robot);

/// The `model` of an arm in a scene file or script: a bundled arm's name, or a robot's file beside the YAML
/// file. @param on_account gets each robot's account, once a file; may be empty.
std::function<MechanismDescription(const std::string&, const std::filesystem::path&)> arm_models(
    const RobotChoices& choices, std::function<void(const std::string& account)> on_account);

}  // namespace touchstone::robot_files
