#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/robot_files/robot_files.hpp"
#include "touchstone/examples/training_run/results/outputs.hpp"

namespace touchstone::training {

struct Options {
  std::vector<std::string> scenes;      ///< numbers, names or files; empty: all scripts
  std::vector<std::string> backends{};  ///< empty: native
  double frame_rate = 0.0;              ///< [Hz]; 0: each script's own
  std::string output = "training";      ///< folder
  std::filesystem::path scripts;        ///< folder
  OutputOptions outputs{};
  robot_files::RobotChoices robots{};
  bool list = false;
};

/// Prints the help and returns nothing for --help. @param scripts the folder that is looked in by default.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv, const std::filesystem::path& scripts);

/// The files of the scripts that are asked for, by name, then those of robots; all scripts where neither is.
/// @throws InputError for a scene that no script flies.
std::vector<std::filesystem::path> find_scripts(const Options& options);

}  // namespace touchstone::training
