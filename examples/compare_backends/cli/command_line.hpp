#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/sets/options.hpp"

namespace CLI {
class App;
}

namespace touchstone::comparison {

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

/// Parses the command line. On --help prints the help and returns nothing with exit_code 0.
/// @throws InputError, one line, for what is no valid command line.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace touchstone::comparison
