#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/tests/world/progress/path_finder.hpp"

namespace touchstone {

/// One mover in its scene, and its commands, frame by frame.
struct ProgressTrial {
  std::unique_ptr<ContactWorld> world;
  std::unique_ptr<MoverModel> model;
  MechanismHandle arm;
  ObjectHandle body;
  bool is_arm = false;
  int frames = 0;
  /// Where it is commanded to go from where it is.
  std::function<Configuration(const Configuration& at, int frame)> command;
  /// Set: it is commanded to go along this path, and only advances; `open_path` is the one that could be
  /// gone.
  std::function<RigidPath(const Pose&X_WO, int frame)> path, open_path;
  bool has_end = false;  ///< the last command stays, and is to be reached as nearly as small steps do

  Configuration at() const;
  /// At s of a part of the last frame.
  Configuration executed(std::size_t part, double s) const;
};

/// @throws std::invalid_argument: no such scene.
ProgressTrial make_trial(std::string_view scene, double rate, double gap, std::uint64_t seed);

}  // namespace touchstone
