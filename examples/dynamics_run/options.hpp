#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/robot_files/robot_files.hpp"

namespace touchstone::dynamics {

struct Options {
  std::vector<std::string> scenes;      ///< numbers, names or files; empty: all bundled ones
  std::vector<std::string> engines{};   ///< `bullet`, `bullet:native`...; empty: own
  std::vector<std::string> backends{};  ///< of the own engine; empty: all
  std::string reference;                ///< empty: exact where it is built, else native
  std::vector<program::SceneSetting> settings{};
  std::string output = "dynamics";  ///< folder
  std::filesystem::path folder;     ///< with the bundled scenes
  std::size_t every = 1;            ///< n-th step is recorded
  int repetitions = 3;              ///< of each run: a step's time is that of its fastest
  double deadline = 0.0;            ///< of a step, for its 99.9th percentile [s]; 0: the scene's step
  double error = 0.0;  ///< allowed of every figure, in its unit or as a share; 0: the scenes' own
  robot_files::RobotChoices robots{};
  bool list = false;
};

/// Prints the help and returns nothing for --help. @param scenes the folder that is looked in by default.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv, const std::filesystem::path& scenes);

/// The files of the scenes that are asked for, by name, then those of robots; all bundled ones where neither
/// is. @throws InputError for one that is not there.
std::vector<std::filesystem::path> find_scenes(const Options& options);

}  // namespace touchstone::dynamics
