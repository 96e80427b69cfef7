#include "touchstone/examples/program/terminal/program.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <new>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"
#include "touchstone/examples/program/terminal/machine.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::program {
namespace {

constexpr int kOtherError = 1;
constexpr int kBadInput = 2;

int fail(const std::string& name, const std::string& error, int code) {
  std::cerr << name << ": " << error << "\n";
  return code;
}

// Whether all that was printed arrived.
bool all_printed = true;

/// A disk may be full that output is sent to.
void flush_output() {
  std::cout.flush();
  if (!all_printed || !std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw std::runtime_error("what was printed could not be written");
}

}  // namespace

int run_program(const std::string& name, const std::function<int()>& run) {
  answer_signals(name);
  try {
    native::kernels();  // an instruction set that nobody knows is an error whatever is run
    const int code = run();
    stop_if_interrupted();
    flush_output();
    return code;
  } catch (const InputError& error) {
    return fail(name, error.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return fail(name, "there is not enough memory for this", kOtherError);
  } catch (const std::exception& error) {
    return fail(name, error.what(), kOtherError);
  }
}

void print_now(const std::string& text) {
  std::cout.flush();
  std::fflush(stdout);
  if (!write_all(own_stdout(), text)) all_printed = false;
}

std::vector<std::string> stems(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files) names.push_back(file.stem().string());
  return names;
}

bool parse_command_line(CLI::App& app, int argc, const char* const* argv) {
  const std::string name =
      app.get_name().empty() ? std::filesystem::path(argv[0]).filename().string() : app.get_name();
  app.set_version_flag("--version", name + " " + touchstone_version());
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::cout << wrapped(app.help());
    return false;
  } catch (const CLI::CallForVersion& version) {
    std::cout << version.what() << "\n";
    return false;
  } catch (const CLI::ParseError& error) {
    throw InputError(one_line(error.what()));
  }
  return true;
}

}  // namespace touchstone::program
