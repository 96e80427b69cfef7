#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/choice.hpp"
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
  std::optional<double> max_error;  ///< [m]; of `choice` where it is given
  Choice choice;                    ///< its query is --query
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

/// The options of a choice, the same for a run and for `decide`.
struct ChoiceOptions {
  std::string query = "distance";
  std::vector<double> max_errors;
  std::vector<std::string> sets, classes;
  bool contacts_only = false, without_normals = false, without_points = false;
  Choice choice;

  void add_to(CLI::App& app);
  /// One a --max-error; one, with the default error, of none.
  /// @throws InputError naming the option that is out of range.
  std::vector<Choice> choices() const;
};
/// @throws InputError naming the sets that there are, where the choice names one that is not among them.
void check_sets(const Choice& choice, const std::vector<std::string>& known);

/// @throws InputError for a name that is none of a query.
QueryKind query_named(const std::string& name);

/// Parses the command line. On --help prints the help and returns nothing with exit_code 0.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace touchstone::comparison
