// Steps small worlds in each engine, with the engine's own check and with ours, in one run, and prints what
// came of them.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

using Run = Outcome (*)(const World&, Check);

/// The same outcome each time; the least of the times.
std::pair<Outcome, Outcome> run_both(const World& world, Run run, int repetitions) {
  std::pair<Outcome, Outcome> best{run(world, Check::engine), run(world, Check::native)};
  for (int i = 1; i < repetitions; ++i) {
    for (auto [kept, check] : {std::pair{&best.first, Check::engine}, {&best.second, Check::native}}) {
      const Outcome again = run(world, check);
      kept->check_us = std::min(kept->check_us, again.check_us);
      kept->step_us = std::min(kept->step_us, again.step_us);
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
      const auto [own, native] = run_both(world, run, repetitions);
      print(engine, world, "own", own);
      print(engine, world, "native", native);
    }
  }
  return 0;
}

}  // namespace
}  // namespace touchstone::engine_check

int main(int argc, char** argv) {
  return touchstone::engine_check::run_all(argc > 1 ? std::stoi(argv[1]) : 3);
}
