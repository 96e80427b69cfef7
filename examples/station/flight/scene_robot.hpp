#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/script_file.hpp"
#include "touchstone/examples/robot_files/robot_files.hpp"
#include "touchstone/examples/station/flight/hand_scales.hpp"
#include "touchstone/examples/station/flight/object_meshes.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::station {

/// How a scene's robot of others is read.
struct SceneRobots {
  robot_files::RobotChoices choices = {};
  std::function<void(const std::string& account)> on_account =
      {};                                 ///< robot_files::account_of(); may be empty
  bool shows_meshes = true;               ///< false: nobody looks, and no mesh is read for a picture
  const SceneScales* recorded = nullptr;  ///< of a replay: hands' rates in place of those by reach
};

/// The robot that a scene flies; the station flies one.
class SceneRobot {
 public:
  /// A script, or a robot's file, which is flown before a block: see training::robot_script(). @throws
  /// InputError as load_script() and robot_files::load_robot_file()
  Script read_script(const std::filesystem::path& file, const SceneRobots& robots);

  /// False: the scene has an arm of ours, or none.
  bool is_flown() const { return is_flown_; }
  /// Meshes that the picture shows of its links in place of hexahedra, and the hexahedra that stand
  /// for no mesh. Links without a mesh have none. @param setting of the script.
  std::vector<ObjectMesh> meshes(const training::Setting& setting) const;

 private:
  MechanismDescription read(const std::filesystem::path& file, const SceneRobots& robots);

  bool is_flown_ = false;
  std::vector<LinkMesh> meshes_;
};

/// Every bit of an arm that a flight depends on: hexahedra and where they are, joints, exempt pairs. The same
/// wherever its files lie.
std::string flown_bits(const training::Arm& arm);

/// How far the arm's links are from its base as they stand at the start [m]; at most so far.
double extent_of(const training::Setting& setting, const training::Arm& arm);
/// How far its links may come from its base, whatever its joints do within their limits: at most the lengths
/// between its joints, what slides move, and the last link's size, added up along each branch [m]. Infinite
/// where a slide has no limit.
double reach_of(const Mechanism& mechanism);

}  // namespace touchstone::station
