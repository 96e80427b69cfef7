#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "touchstone/examples/program/terminal/progress.hpp"

namespace CLI {
class App;  // its header costs each file that includes it seconds
}

namespace touchstone::program {

/// A program's main: SIGINT and SIGTERM are answered within a second (130 and 143, see interruption.hpp), and
/// every error is one line on stderr after the program's name.
/// @return what `run` returns; 2 for an InputError; 1 for any other error, one of them output that did not
/// arrive.
int run_program(const std::string& name, const std::function<int()>& run);

/// Prints at once, so that a reader behind a pipe sees it, past an EngineLog.
void print_now(const std::string& text);

/// Runs each input with progress, hands its result to `done` and prints what that returns before the next one
/// starts.
template <class Input, class Run, class Done>
void run_each(const std::vector<Input>& inputs, const Run& run, const Done& done) {
  ProgressLine progress;
  for (const Input& input : inputs) {
    auto result = run(input, progress);
    progress.finish();
    print_now(done(std::move(result)));
  }
}

/// The names of files without folder and extension.
std::vector<std::string> stems(const std::vector<std::filesystem::path>& files);

/// Adds --version.
/// @return false when only help or the version was asked for, which is printed then.
/// @throws InputError, in one line, for what the command line may not hold.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

}  // namespace touchstone::program
