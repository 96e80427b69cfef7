// Steps small worlds in each engine, with the engine's own check and with ours, in one run, and prints what
// came of them.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "examples/engine_check/world.hpp"
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
#include "adapters/scene_files/pair_capture.hpp"
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
    }
  }
  return best;
}

void print(const char* engine, const World& world, const char* check, const Outcome& out) {
  const double error = world.end ? norm(Vector3(out.end - *world.end)) : -1.0;
  std::printf("| %s | %s | %s | ", engine, world.name.c_str(), check);
  if (world.end)
    std::printf("%.2g | %.2g", error, std::abs(out.end.z() - world.end->z()));
  else
    std::printf("leans %.3f | z %.3f", out.lean, out.end.z());
  std::printf(" | %.2g | %.2g | %.2g | %.2g | %zu | %.1f | %.1f |\n", out.drift, out.rise, out.speed,
              out.turn, out.contacts, out.check_us, out.step_us);
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

int run_all(int repetitions) {
  std::printf(
      "| engine | world | check | end off [m] | in height [m] | drift [m] | rise [m] | speed [m/s] | turn "
      "[rad/s] | contacts | check [us] | step [us] |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::vector<World> worlds = all_worlds();
  for (const auto& [engine, run] : kEngines) {
    for (const World& world : worlds) {
      std::vector<Check> checks = {Check::engine, Check::native};
      if (aborts(engine, world)) {
        std::printf("| ODE | %s | own | aborts the process: a rotation is no number |\n", world.name.c_str());
        checks = {Check::native};
      }
      const std::vector<Outcome> outcomes = run_checks(world, run, checks, repetitions);
      for (std::size_t k = 0; k < checks.size(); ++k)
        print(engine, world, checks[k] == Check::engine ? "own" : "native", outcomes[k]);
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
  const std::string_view first = argc > 1 ? argv[1] : "3";
  try {
#ifdef TOUCHSTONE_ENGINE_CHECK_CAPTURE
    if (first == "--capture" && argc == 3) return touchstone::engine_check::capture_all(argv[2]);
#endif
    return touchstone::engine_check::run_all(std::stoi(std::string(first)));
  } catch (const std::exception&) {
    std::fprintf(stderr,
                 "engine_check [REPETITIONS] | --capture PREFIX (writes PREFIXBullet.json and so on)\n");
    return 2;
  }
}
