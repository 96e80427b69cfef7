#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/examples/program/choices.hpp"

namespace CLI {
class App;
}

namespace touchstone::comparison {

struct Options {
  std::vector<std::string> backends;  ///< empty: all
  std::vector<std::string> families;  ///< empty: all
  std::vector<std::string> scenes;
  std::vector<SceneSetting> scene_settings;
  std::string pairs_file;            ///< of --pairs or --capture
  bool is_capture = false;           ///< of --capture: an engine's answers are expected in it
  std::string dynamics_file;         ///< results.json of dynamics_run; empty: none
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
  std::string command_line;  ///< quoted, as a shell takes it back

  std::size_t pair_count() const { return count.value_or(quick ? 500 : 20000); }
};

/// --query, "distance" unless it is given.
void add_query_option(CLI::App& app, std::string& query);
/// @throws InputError for a name that is none of a query.
QueryKind query_named(const std::string& name);

/// @throws InputError for what is no allowed error [m].
double checked_max_error(double max_error);

/// Parses the command line. On --help prints the help and returns nothing with exit_code 0.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace touchstone::comparison
