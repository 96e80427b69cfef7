#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/examples/station/flight/hand_scales.hpp"
#include "touchstone/examples/station/flight/object_meshes.hpp"
#include "touchstone/examples/station/flight/scene_robot.hpp"
#include "touchstone/examples/station/flight/station_dynamics.hpp"
#include "touchstone/examples/station/flight/tasks.hpp"
#include "touchstone/examples/station/flight/tips.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::station {

/// A pair that may be latched, as a script's actions at times above 0 name it.
struct LatchOption {
  std::uint32_t carrier, carried;  ///< objects
  std::vector<SolidPair> allowed;
};

/// A fixture that may hold an end of an arm that walks, as a script's holds name it. A fixture's z axis is
/// its probe's, away from its plate, where its origin is.
struct HoldOption {
  std::uint32_t tip;      ///< of StationScene::tips
  std::uint32_t fixture;  ///< object
  bool at_start;          ///< the arm stands on it at first
};

inline constexpr double kFarthestView = 5.0;  ///< [m]

/// A scene that can be flown: a hand-controller script (adapters/scene_files/README.md) whose rates are the
/// hands' instead. Its first hand is flown. Latches at time 0 hold at the start; they and the later ones are
/// those that an operator may ask for. Its other actions are passed by.
struct StationScene {
  /// @throws InputError as training::Setting; holds that no arm with two ends, one of them its base, can
  /// mean.
  StationScene(std::string name, Script script, double rate);

  std::string name;            ///< scene_name() of the file
  std::filesystem::path file;  ///< it; absolute
  /// A hash of what is in it, in the scene's file and in its tasks', and of a robot of others as it is flown.
  std::string files;
  training::Setting setting;
  std::vector<training::Action> initial;
  std::vector<LatchOption> latches;
  std::vector<HoldOption> holds;                    ///< empty: the arm stands on its base for ever
  std::vector<StationTask> tasks;                   ///< at most kMostTasks
  std::vector<Tip> tips;                            ///< what the hand may fly, at least one
  std::shared_ptr<const StationDynamics> dynamics;  ///< null: the scene's file has no guarded dynamics
  /// How far from the hand the main camera starts [m]; other cameras stand in proportion. Of a robot of
  /// others twice its extent_of() at the start, but no more than of our arms.
  double view = kFarthestView;
  HandScales scales;    ///< of a robot of others by its reach; of a replay as recorded
  ObjectMeshes meshes;  ///< of the robot that is flown, where its file has some

  /// Null: the hand flies a free object.
  const training::Arm* arm() const { return setting.arms().empty() ? nullptr : setting.arms().data(); }
  /// The object that the hand flies at first: of an arm, its last link with hexahedra on the flown link's
  /// chain.
  std::uint32_t hand_object() const { return tips[0].object; }
};

/// The file's name without its ending. Of one that is no UTF-8 the bytes beyond ASCII are written as %XX, so
/// that pages and recordings can name the scene.
std::string scene_name(const std::filesystem::path& file);

/// Tasks come from NAME.tasks.json beside NAME.yaml, where there is one: see read_tasks().
/// The picture's meshes come from NAME.meshes.json: see read_meshes(); and from the robot's file.
/// @param script or a robot's file. @param rate frames a second. @throws InputError as
/// SceneRobot::read_script(); a script without a hand, or whose hand is not the only one on an arm.
std::unique_ptr<const StationScene> load_station_scene(const std::filesystem::path& script, double rate,
                                                       const SceneRobots& robots = {});

/// The `scene` message of protocol.md, but for its serial.
std::string scene_json(const StationScene& scene);

}  // namespace touchstone::station
