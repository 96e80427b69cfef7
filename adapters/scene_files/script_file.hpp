#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/scene_file.hpp"

namespace touchstone {

/// The command of a pair of hand controllers from a time on, until the next row.
struct HandRates {
  double time = 0.0;                   ///< [s]
  Vector3 velocity = Vector3::Zero();  ///< of the object's origin [m/s]
  Vector3 turn = Vector3::Zero();      ///< angular velocity about its origin [rad/s]
  /// Whose axes the rates are along.
  enum class Mode : std::uint8_t {
    world,  ///< both along the world's axes
    hand,   ///< both along the object's own axes, as they stand at the frame's start
  } mode = Mode::world;

  bool at_rest() const { return velocity == Vector3::Zero() && turn == Vector3::Zero(); }
};

/// An arm in the scene, one of whose links is flown by resolved rates.
struct ArmScript {
  std::string
      model;  ///< a bundled arm (mechanism/arms/bundled_arms.hpp) or a robot's file, as the script has it
  std::shared_ptr<const Mechanism> mechanism = {};
  std::string link;            ///< that is flown
  std::vector<double> joints;  ///< values at the start [rad or m]
  Pose X_WL;                   ///< of the link at the start; the arm's base stands where that puts it
  /// After a stop, or a slide that took the link aside, the hand goes back to where it asked the link to be
  /// along the axes on which it asks for no rate, and to the attitude where it asks for no turn. Otherwise
  /// rates go on from where the link is.
  bool holds = false;
  std::vector<std::string> held_joints = {};  ///< that the hand does not drive: other joints serve its rates
};

/// One hand on one object or arm.
struct HandScript {
  std::string object;            ///< empty: it flies the arm
  std::vector<HandRates> rates;  ///< by time, at least one; before the first all are 0
  std::optional<ArmScript> arm;  ///< exactly where there is no object
};

/// An action of the operator besides flying; in force from the first frame on that starts at `time` or later.
struct OperatorAction {
  /// The kind of action; `switch_on` and `switch_off` are of the object's selection.
  /// `hold`: of an arm that walks a fixture may hold an end where it stands, at time 0 it does.
  enum class Kind : std::uint8_t { latch, release, switch_on, switch_off, hold } kind = Kind::latch;
  double time = 0.0;    ///< [s]
  std::string object;   ///< carried, released, switched; of a hold the arm's link
  std::string carrier;  ///< latch: an object, or a link of a flown arm (`ssrms.tip_lee`); hold: the fixture
  std::vector<ExemptPair> allowed = {};  ///< latch only: not checked as well, while it holds
};

/// A hand-controller script: a scene and what an operator does in it.
struct Script {
  std::string name;
  std::string description;
  Scene scene;                    ///< with the script's own policy, frame rate and duration
  bool translation_only = false;  ///< slide: without turning
  std::vector<HandScript> hands;
  std::vector<OperatorAction> actions;    ///< by time
  std::filesystem::path scene_file = {};  ///< that load_script() read; for those who want its dynamics, too
};

/// Frame rates that scripts may ask for, from the first to the second [Hz].
inline constexpr double kLowestFrameRate = 10.0, kHighestFrameRate = 1000.0;  ///< [Hz]

/// Reads a script (YAML; the format is described in adapters/scene_files/README.md) and its scene, which is
/// named relative to the script. Prescribed motion in the scene file is left out: only hands move objects.
/// @throws InputError, one line `file:line: reason`, as load_scene; further: a frame rate out of 10 to 1000
/// Hz, objects that the scene has not or that two hands fly, rows out of order.
/// @param arm_models empty: bundled arms only.
Script load_script(const std::filesystem::path& path, const ArmModels& arm_models = {});

}  // namespace touchstone
