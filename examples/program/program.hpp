#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "touchstone/examples/program/progress.hpp"

namespace touchstone::comparison {

/// A program's main: SIGINT and SIGTERM interrupt at the next progress call, and every error is one line on
/// stderr after the program's name.
/// @return what `run` returns; 2 for an InputError, 130 after an interrupt, 1 for any other error.
int run_program(const std::string& name, const std::function<int()>& run);

/// Prints, and flushes so that a reader behind a pipe sees it.
void print_now(const std::string& text);

/// Runs each input with progress and prints what `text` says of its result before the next one starts.
template <class Input, class Run, class Text>
auto run_each(const std::vector<Input>& inputs, const Run& run, const Text& text) {
  ProgressLine progress;
  std::vector<std::invoke_result_t<Run, const Input&, ProgressLine&>> results;
  for (const Input& input : inputs) {
    results.push_back(run(input, progress));
    progress.finish();
    print_now(text(results.back()));
  }
  return results;
}

/// @return false when only help was asked for, which is printed then.
/// @throws InputError, in one line, for what the command line may not hold.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

}  // namespace touchstone::comparison
