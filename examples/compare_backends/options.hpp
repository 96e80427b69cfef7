#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::comparison {

/// --set [SCENE:]NAME=VALUE: a parameter of one scene (by its file's stem), or of every scene that has it.
struct SceneSetting {
  std::string scene;  ///< empty: every scene
  std::string name;
  double value = 0;  ///< in the file's units
};

struct Options {
  std::vector<std::string> backends;  ///< empty: all
  std::vector<std::string> families;  ///< empty: all
  std::vector<std::string> scenes;
  std::vector<SceneSetting> scene_settings;
  std::string pairs_file;            ///< of --pairs or --capture
  std::optional<std::size_t> count;  ///< pairs a family
  std::uint64_t seed = 1;
  std::optional<double> max_error;  ///< [m]
  QueryKind query = QueryKind::distance;
  std::string case_id;
  std::string output = "report";
  int repetitions = 9;
  int threads = 2;
  bool families_given = false;
  bool no_families = false;
  bool no_broadphase = false;
  bool quick = false;
  bool list = false;
  std::string command_line;

  std::size_t pair_count() const { return count.value_or(quick ? 500 : 20000); }
};

/// Parses the command line. On --help prints the help and returns nothing with exit_code 0.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace touchstone::comparison
