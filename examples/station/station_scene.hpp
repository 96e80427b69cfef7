#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/examples/station/station_dynamics.hpp"
#include "touchstone/examples/training_run/setting.hpp"

namespace touchstone::station {

/// A pair that may be latched, as a script's actions at times above 0 name it.
struct LatchOption {
  std::uint32_t carrier, carried;  ///< objects
  std::vector<SolidPair> allowed;
};

/// A goal, judged in `ours`.
struct StationTask {
  /// `carry`: the object is carried. `place`: it is carried by nobody, its origin within `within` of `p_W`.
  /// `reach`: the flown frame's origin is.
  enum class Kind : std::uint8_t { carry, place, reach } kind = Kind::reach;
  std::string name, title;
  std::uint32_t object = 0;
  Vector3 p_W = Vector3::Zero();  ///< [m]
  double within = 0.0;            ///< [m]
  // Until it is done, since the last reset; infinite, or the most there is: none.
  double most_force = std::numeric_limits<double>::infinity();  ///< GuardedMethod::contact_force() [N]
  double most_time = std::numeric_limits<double>::infinity();   ///< [s]
  std::uint32_t most_contacts = 0xffffffff;                     ///< that began
};
inline constexpr std::size_t kMostTasks = 8;

/// A scene that can be flown: a hand-controller script (adapters/scene_files/README.md) whose rates are the
/// hands' instead. Its first hand is flown. Latches at time 0 hold at the start; they and the later ones are
/// those that an operator may ask for. Its other actions are passed by.
struct StationScene {
  /// @throws InputError as training::Setting.
  StationScene(std::string name, Script script, double rate);

  std::string name;            ///< the file's
  std::filesystem::path file;  ///< it; absolute
  std::string files;           ///< a hash of what is in it, in the scene's file and in its tasks'
  training::Setting setting;
  std::vector<training::Action> initial;
  std::vector<LatchOption> latches;
  std::vector<StationTask> tasks;  ///< at most kMostTasks
  Pose X_HT;                       ///< the flown frame in the object that stands for the hand
  std::shared_ptr<const StationDynamics> dynamics;  ///< null: the scene's file has no guarded dynamics

  /// Null: the hand flies a free object.
  const training::Arm* arm() const { return setting.arms().empty() ? nullptr : setting.arms().data(); }
  /// The object that the hand flies: of an arm, its last link with hexahedra on the flown link's chain.
  std::uint32_t hand_object() const;
};

/// Tasks come from NAME.tasks.json beside NAME.yaml, where there is one: a list of {"name", "title", "kind",
/// and of its kind "object", "position" [m], "within" [m], "limits": {"force" [N], "time" [s], "contacts"}},
/// each limit left out: none.
/// @param rate frames a second. @throws InputError as load_script(); a script without a hand, or whose hand
/// is not the only one on an arm.
std::unique_ptr<const StationScene> load_station_scene(const std::filesystem::path& script, double rate);

/// The `scene` message of protocol.md, but for its serial.
std::string scene_json(const StationScene& scene);

}  // namespace touchstone::station
