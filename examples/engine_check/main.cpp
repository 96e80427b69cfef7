// Steps small worlds in each engine, with the engine's own check and with ours, in one run, and prints what
// came of them.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "touchstone/adapters/all/if_built.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/engine_check/world.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
#include "touchstone/adapters/scene_files/pair_capture.hpp"
#endif

namespace touchstone::engine_check {
namespace {

using program::print_now;
using Run = Outcome (*)(const World&, Check, PairObserver*);

/// The outcome is the same each time; the least of the times. Both checks in turn, so that a busy machine
/// meets both.
std::vector<Outcome> run_checks(const World& world, Run run, const std::vector<Check>& checks,
                                int repetitions) {
  std::vector<Outcome> best;
  for (const Check check : checks) best.push_back(run(world, check, nullptr));
  for (int i = 1; i < repetitions; ++i) {
    for (std::size_t k = 0; k < checks.size(); ++k) {
      const Outcome again = run(world, checks[k], nullptr);
      best[k].check_us = std::min(best[k].check_us, again.check_us);
      best[k].step_us = std::min(best[k].step_us, again.step_us);
      for (auto& [contacts, with] : best[k].steps_with)
        with.step_us = std::min(with.step_us, again.steps_with.at(contacts).step_us);
    }
  }
  return best;
}

/// How long our step takes of theirs, those steps compared that had as many contacts: the two runs differ in
/// how long they rock, slide or rest. Weighted by the steps; counts that either had seldom are left out.
std::optional<double> step_ratio(const Outcome& own, const Outcome& ours) {
  constexpr std::size_t kSeldom = 20;
  double sum = 0.0, weights = 0.0;
  for (const auto& [contacts, with] : ours.steps_with) {
    const auto same = own.steps_with.find(contacts);
    if (same == own.steps_with.end()) continue;
    const std::size_t steps = std::min(with.steps, same->second.steps);
    if (steps < kSeldom) continue;
    sum += static_cast<double>(steps) * with.step_us / same->second.step_us;
    weights += static_cast<double>(steps);
  }
  return weights > 0.0 ? std::optional(sum / weights) : std::nullopt;
}

void print(const char* engine, const World& world, const char* check, const Outcome& out,
           const Outcome* own) {
  const double error = world.end ? norm(Vector3(out.end - *world.end)) : -1.0;
  std::string row = fmt::format("| {} | {} | {} | ", engine, world.name, check);
  if (world.end)
    row += fmt::format("{:.2g} | {:.2g}", error, std::abs(out.end.z() - world.end->z()));
  else
    row += fmt::format("leans {:.3f} | z {:.3f}", out.lean, out.end.z());
  row += fmt::format(" | {:.2g} | {:.2g} | {:.2g} | {:.2g} | {} | {:.1f} | {:.1f} |", out.drift, out.rise,
                     out.speed, out.turn, out.contacts, out.check_us, out.step_us);
  const std::optional<double> ratio = own != nullptr ? step_ratio(*own, out) : std::nullopt;
  if (ratio) row += fmt::format(" {:.2f}", *ratio);
  print_now(row + " |\n");
}

std::vector<World> all_worlds() {
  return {stack(10, false), wall(12, false), seams(false),     toppling(0.95), toppling(1.05),
          stack(10, true),  wall(12, true),  frustum_stack(8), seams(true)};
}

/// An engine that a build may lack.
struct Engine {
  const char* name;
  Run run;              // null: not in this build
  const char* missing;  // why, where it is not
};

constexpr Engine kEngines[] = {
    {"Bullet", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_BULLET_RUN, run_bullet),
     "no double-precision Bullet was found"},
    {"ODE", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_ODE_RUN, run_ode), "no double-precision ODE was found"},
    {"MuJoCo", TOUCHSTONE_IF_BUILT(TOUCHSTONE_BUILT_MUJOCO_RUN, run_mujoco), "MuJoCo was not found"},
};

bool aborts(const char* engine, const World& world) {
  return world.ode_aborts && std::string_view(engine) == "ODE";
}
/// From some starts a rotation becomes no number with ODE's convexes in any world.
bool may_abort(const char* engine, const World& world) {
  return world.by_hulls && std::string_view(engine) == "ODE";
}

/// Those of this build, or the one asked for.
/// @throws InputError for an engine that is unknown or not in this build.
std::vector<Engine> asked_engines(std::string_view only) {
  std::vector<Engine> asked;
  std::string known;
  for (const Engine& engine : kEngines) {
    if (only == engine.name && engine.run == nullptr)
      throw InputError("engine '" + std::string(only) + "': not in this build: " + engine.missing);
    if (engine.run == nullptr) continue;
    if (only.empty() || only == engine.name) asked.push_back(engine);
    known += (known.empty() ? "" : ", ") + std::string(engine.name);
  }
  if (asked.empty()) throw InputError("unknown engine '" + std::string(only) + "', this build has: " + known);
  return asked;
}

int run_all(int repetitions, std::string_view only) {
  print_now(
      "| engine | world | check | end off [m] | in height [m] | drift [m] | rise [m] | speed [m/s] | turn "
      "[rad/s] | contacts | check [us] | step [us] | step over own, same contacts |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::vector<World> worlds = all_worlds();
  for (const auto& [engine, run, missing] : asked_engines(only)) {
    for (const World& world : worlds) {
      std::vector<Check> checks = {Check::engine, Check::native};
      if (aborts(engine, world)) {
        print_now("| ODE | " + world.name + " | own | aborts the process: a rotation is no number |\n");
        checks = {Check::native};
      }
      const std::vector<Outcome> outcomes = run_checks(world, run, checks, repetitions);
      for (std::size_t k = 0; k < checks.size(); ++k)
        print(engine, world, checks[k] == Check::engine ? "own" : "native", outcomes[k],
              k > 0 ? &outcomes[0] : nullptr);
    }
  }
  return 0;
}

std::string range_text(const std::vector<double>& values) {
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  return fmt::format(" {:.2g} ({:.2g} to {:.2g}) |", median(values), *least, *largest);
}

/// Stillness from many starts: the median, the least and the largest.
int run_starts(unsigned starts, std::string_view only) {
  print_now(
      "| engine | world | check | off [m] | in height [m] | speed at the end [m/s] |\n"
      "|---|---|---|---|---|---|\n");
  const World worlds[] = {stack(10, false), wall(12, false), frustum_stack(8), seams(false)};
  for (const auto& [engine, run, missing] : asked_engines(only)) {
    for (const World& world : worlds) {
      for (const Check check : {Check::engine, Check::native}) {
        // An engine that aborts would end the whole table.
        if (check == Check::engine && may_abort(engine, world)) continue;
        // Starts that differ slightly show how far results scatter.
        std::vector<double> off, height, speed;
        for (unsigned start = 0; start < starts; ++start) {
          const World each = shifted(world, start);
          const Outcome out = run(each, check, nullptr);
          off.push_back(norm(Vector3(out.end - *each.end)));
          height.push_back(std::abs(out.end.z() - each.end->z()));
          speed.push_back(out.speed);
        }
        // The row has the range over all starts.
        std::string row =
            fmt::format("| {} | {} | {} |", engine, world.name, check == Check::engine ? "own" : "native");
        for (const auto* values : {&off, &height, &speed}) row += range_text(*values);
        print_now(row + "\n");
      }
    }
  }
  return 0;
}

/// Every world stepped with each engine's own check, captured: a file an engine.
/// @throws InputError for a file that is there, before any world is stepped.
int capture_all([[maybe_unused]] const std::string& prefix) {
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
  constexpr std::size_t kMost = 2000;
  const auto file_of = [&](const char* engine) { return prefix + engine + ".json"; };
  const std::vector<Engine> engines = asked_engines("");
  for (const auto& [engine, run, missing] : engines)
    if (std::filesystem::exists(std::filesystem::symlink_status(file_of(engine))))
      throw InputError("--capture: " + file_of(engine) + " is there; move it away or name another prefix");
  for (const auto& [engine, run, missing] : engines) {
    PairCapture capture(kMost);
    for (const World& world : all_worlds())
      if (!aborts(engine, world)) run(world, Check::engine, &capture);
    capture.save(file_of(engine));
    print_now(
        fmt::format("{}: {} of {} pairs\n", file_of(engine), capture.cases().size(), capture.observed()));
  }
  return 0;
#else
  throw InputError("--capture: this build writes no pair files (adapter scene_files is off)");
#endif
}

struct Options {
  int repetitions = 3;
  std::optional<int> starts;
  std::string engine;  // empty: all
  std::string capture_prefix, log;
};

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Options options;
  int starts = 0;
  CLI::App app{"Steps small worlds in each engine, with the engine's own check and with ours."};
  auto* repetitions = app.add_option("REPETITIONS", options.repetitions, "Of each run; the least time counts")
                          ->check(CLI::Range(1, 1000))
                          ->capture_default_str();
  app.add_option("ENGINE", options.engine, "Only this one");
  auto* count = app.add_option("--starts", starts, "Stillness from so many starts instead")
                    ->check(CLI::Range(1, 100000));
  app.add_option("--engine", options.engine, "Only this one");
  app.add_option("--capture", options.capture_prefix,
                 "Captures pairs instead: writes PREFIXBullet.json and so on");
  app.add_option("--log", options.log, "A new file for what engines say by themselves");
  if (!program::parse_command_line(app, argc, argv)) return std::nullopt;
  if (*count && *repetitions) throw InputError("--starts: has no repetitions");
  if (*count) options.starts = starts;
  asked_engines(options.engine);
  if (!options.log.empty() && std::filesystem::exists(std::filesystem::symlink_status(options.log)))
    throw InputError("--log: " + options.log + " is there; name another file");
  return options;
}

/// The lines that engines wrote by themselves, for the file that was asked for; empty: none was.
void keep_lines(const std::string& file, const std::string& text) {
  if (file.empty()) return;
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw std::runtime_error(file + ": cannot be written");
}

/// Writes the engines' lines where they were asked to go, and counts them.
void tell_of(const program::EngineLog& log, const std::string& file) {
  const std::size_t lines = program::engine_log_lines();
  if (lines == 0) return;
  program::say(fmt::format("{} lines that engines wrote{}\n", lines,
                           file.empty() ? " are left out (--log FILE keeps them)" : ": " + file));
  keep_lines(file, log.text());
}

/// For a run that a signal ends: its rows are printed as they come, the log is written here.
std::string tell_of_part(const program::EngineLog& log, const std::string& file) {
  const std::size_t lines = program::engine_log_lines();
  keep_lines(file, "partial: interrupted before the last world\n" + log.text());
  return fmt::format(
      "interrupted: the rows above are complete, the others were not measured{}",
      file.empty() ? std::string() : fmt::format("; {} lines that engines wrote so far: {}", lines, file));
}

int run(int argc, const char* const* argv) {
  const std::optional<Options> options = parse_options(argc, argv);
  if (!options) return 0;
  const program::EngineLog log;
  std::optional<program::OnInterrupt> on_interrupt([&] { return tell_of_part(log, options->log); });
  int code = 0;
  if (!options->capture_prefix.empty())
    code = capture_all(options->capture_prefix);
  else if (options->starts)
    code = run_starts(static_cast<unsigned>(*options->starts), options->engine);
  else
    code = run_all(options->repetitions, options->engine);
  on_interrupt.reset();
  program::stop_if_interrupted();  // before a log that is whole
  tell_of(log, options->log);
  return code;
}

}  // namespace
}  // namespace touchstone::engine_check

int main(int argc, char** argv) {
  return touchstone::program::run_program("engine_check",
                                          [&] { return touchstone::engine_check::run(argc, argv); });
}
