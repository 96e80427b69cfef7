#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace touchstone::comparison {

/// A program's main: SIGINT and SIGTERM interrupt at the next progress call, and every error is one line on
/// stderr after the program's name.
/// @return what `run` returns; 2 for an InputError, 130 after an interrupt, 1 for any other error.
int run_program(const std::string& name, const std::function<int()>& run);

/// @return false when only help was asked for, which is printed then.
/// @throws InputError, in one line, for what the command line may not hold.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

}  // namespace touchstone::comparison
