#include "touchstone/examples/program/program.hpp"

#include <algorithm>
#include <csignal>
#include <iostream>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/progress.hpp"

namespace touchstone::comparison {
namespace {

constexpr int kOtherError = 1;
constexpr int kBadInput = 2;
constexpr int kInterrupted = 130;

void on_signal(int) { ProgressLine::interrupted = true; }

int fail(const std::string& name, const std::exception& error, int code) {
  std::cerr << name << ": " << error.what() << "\n";
  return code;
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

int run_program(const std::string& name, const std::function<int()>& run) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    return run();
  } catch (const Interrupted& interrupted) {
    return fail(name, interrupted, kInterrupted);
  } catch (const InputError& error) {
    return fail(name, error, kBadInput);
  } catch (const std::exception& error) {
    return fail(name, error, kOtherError);
  }
}

void print_now(const std::string& text) { std::cout << text << std::flush; }

bool parse_command_line(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    return false;
  } catch (const CLI::ParseError& error) {
    throw InputError(one_line(error.what()));
  }
  return true;
}

}  // namespace touchstone::comparison
