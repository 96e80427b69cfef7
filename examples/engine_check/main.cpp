// Steps small worlds in each engine, with the engine's own check and with ours, in one run, and prints what
// came of them.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "touchstone/examples/engine_check/world.hpp"
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
#include "touchstone/adapters/scene_files/pair_capture.hpp"
#endif

namespace touchstone::engine_check {
namespace {

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
  std::printf("| %s | %s | %s | ", engine, world.name.c_str(), check);
  if (world.end)
    std::printf("%.2g | %.2g", error, std::abs(out.end.z() - world.end->z()));
  else
    std::printf("leans %.3f | z %.3f", out.lean, out.end.z());
  std::printf(" | %.2g | %.2g | %.2g | %.2g | %zu | %.1f | %.1f |", out.drift, out.rise, out.speed, out.turn,
              out.contacts, out.check_us, out.step_us);
  const std::optional<double> ratio = own != nullptr ? step_ratio(*own, out) : std::nullopt;
  if (ratio) std::printf(" %.2f", *ratio);
  std::printf(" |\n");
}

std::vector<World> all_worlds() {
  return {stack(10, false), wall(12, false), seams(false),     toppling(0.95), toppling(1.05),
          stack(10, true),  wall(12, true),  frustum_stack(8), seams(true)};
}

constexpr std::pair<const char*, Run> kEngines[] = {
#ifdef TOUCHSTONE_ENGINE_CHECK_BULLET
    {"Bullet", run_bullet},
#endif
#ifdef TOUCHSTONE_ENGINE_CHECK_ODE
    {"ODE", run_ode},
#endif
#ifdef TOUCHSTONE_ENGINE_CHECK_MUJOCO
    {"MuJoCo", run_mujoco},
#endif
};

bool aborts(const char* engine, const World& world) {
  return world.ode_aborts && std::string_view(engine) == "ODE";
}
/// From some starts a rotation becomes no number with ODE's convexes in any world.
bool may_abort(const char* engine, const World& world) {
  return world.by_hulls && std::string_view(engine) == "ODE";
}

bool is_asked(const char* engine, std::string_view only) { return only.empty() || only == engine; }

int run_all(int repetitions, std::string_view only) {
  std::printf(
      "| engine | world | check | end off [m] | in height [m] | drift [m] | rise [m] | speed [m/s] | turn "
      "[rad/s] | contacts | check [us] | step [us] | step over own, same contacts |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::vector<World> worlds = all_worlds();
  for (const auto& [engine, run] : kEngines) {
    if (!is_asked(engine, only)) continue;
    for (const World& world : worlds) {
      std::vector<Check> checks = {Check::engine, Check::native};
      if (aborts(engine, world)) {
        std::printf("| ODE | %s | own | aborts the process: a rotation is no number |\n", world.name.c_str());
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

void print_range(const std::vector<double>& values) {
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  std::printf(" %.2g (%.2g to %.2g) |", median(values), *least, *largest);
}

/// Stillness from many starts: the median, the least and the largest.
int run_starts(unsigned starts, std::string_view only) {
  std::printf(
      "| engine | world | check | off [m] | in height [m] | speed at the end [m/s] |\n"
      "|---|---|---|---|---|---|\n");
  const World worlds[] = {stack(10, false), wall(12, false), frustum_stack(8), seams(false)};
  for (const auto& [engine, run] : kEngines) {
    if (!is_asked(engine, only)) continue;
    for (const World& world : worlds) {
      for (const Check check : {Check::engine, Check::native}) {
        if (check == Check::engine && may_abort(engine, world)) continue;
        std::vector<double> off, height, speed;
        for (unsigned start = 0; start < starts; ++start) {
          const World each = shifted(world, start);
          const Outcome out = run(each, check, nullptr);
          off.push_back(norm(Vector3(out.end - *each.end)));
          height.push_back(std::abs(out.end.z() - each.end->z()));
          speed.push_back(out.speed);
        }
        std::printf("| %s | %s | %s |", engine, world.name.c_str(),
                    check == Check::engine ? "own" : "native");
        for (const auto* values : {&off, &height, &speed}) print_range(*values);
        std::printf("\n");
        std::fflush(stdout);
      }
    }
  }
  return 0;
}

#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
/// Every world stepped with each engine's own check, captured: a file an engine.
int capture_all(const std::string& prefix) {
  constexpr std::size_t kMost = 2000;
  for (const auto& [engine, run] : kEngines) {
    PairCapture capture(kMost);
    for (const World& world : all_worlds())
      if (!aborts(engine, world)) run(world, Check::engine, &capture);
    const std::string file = prefix + engine + ".json";
    capture.save(file);
    std::printf("%s: %zu of %zu pairs\n", file.c_str(), capture.cases().size(), capture.told());
  }
  return 0;
}
#endif

}  // namespace
}  // namespace touchstone::engine_check

int main(int argc, char** argv) {
  using namespace touchstone::engine_check;
  const std::string_view first = argc > 1 ? argv[1] : "3";
  try {
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
    if (first == "--capture" && argc == 3) return capture_all(argv[2]);
#endif
    if (first == "--starts" && argc >= 3)
      return run_starts(static_cast<unsigned>(std::max(1, std::stoi(argv[2]))), argc > 3 ? argv[3] : "");
    return run_all(std::stoi(std::string(first)), argc > 2 ? argv[2] : "");
  } catch (const std::exception&) {
    std::fprintf(
        stderr,
        "engine_check [REPETITIONS [ENGINE]] | --starts COUNT [ENGINE] (stillness from many starts) | "
        "--capture PREFIX (writes PREFIXBullet.json and so on)\n");
    return 2;
  }
}
