// Steps small worlds in each engine, with the engine's own check and with ours, in one run, and prints what
// came of them.

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

using Run = Outcome (*)(const World&, Check);

/// The outcome is the same each time; the least of the times. Both checks in turn, so that a busy machine
/// meets both.
std::vector<Outcome> run_checks(const World& world, Run run, const std::vector<Check>& checks,
                                int repetitions) {
  std::vector<Outcome> best;
  for (const Check check : checks) best.push_back(run(world, check));
  for (int i = 1; i < repetitions; ++i) {
    for (std::size_t k = 0; k < checks.size(); ++k) {
      const Outcome again = run(world, checks[k]);
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

int run_all(int repetitions) {
  const std::vector<World> worlds = {stack(10, false), wall(12, false),  seams(false),
                                     toppling(0.95),   toppling(1.05),   stack(10, true),
                                     wall(12, true),   frustum_stack(8), seams(true)};
  std::printf(
      "| engine | world | check | end off [m] | in height [m] | drift [m] | rise [m] | speed [m/s] | "
      "turn [rad/s] | contacts | check [us] | step [us] "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::pair<const char*, Run> engines[] = {
#ifdef TOUCHSTONE_ENGINE_CHECK_BULLET
      {"Bullet", run_bullet},
#endif
#ifdef TOUCHSTONE_ENGINE_CHECK_ODE
      {"ODE", run_ode},
#endif
  };
  for (const auto& [engine, run] : engines) {
    for (const World& world : worlds) {
      std::vector<Check> checks = {Check::engine, Check::native};
      if (world.ode_aborts && std::string_view(engine) == "ODE") {
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

}  // namespace
}  // namespace touchstone::engine_check

int main(int argc, char** argv) {
  return touchstone::engine_check::run_all(argc > 1 ? std::stoi(argv[1]) : 3);
}
