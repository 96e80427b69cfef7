// The cost of our check inside an engine:
//   engine_checks_benchmark SCENE.yaml [ENGINES [SECONDS [PARAMETER=FIGURE]...]]
//
// Each engine steps the scene with its own check and with ours, the two worlds in turns, so that what else
// the machine does falls on both: processor time of a step (median, 99.9 %, most), ours over its own
// (medians), the contacts of a step, and at the end the fastest point and the deepest overlap. Cut short at
// SECONDS of processor time an engine (default 60), which is said. ENGINES: by commas (default: all with both
// checks).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/all/all_engines.hpp"
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

struct World {
  std::unique_ptr<DynamicsEngine> engine;
  std::vector<double> times;
  double spent = 0.0, contacts = 0.0;
  std::string failure;

  void step() {
    engine->begin_step();
    const double start = processor_us();
    const EngineStep step = engine->step();
    times.push_back(processor_us() - start);
    spent += times.back();
    contacts += static_cast<double>(step.contacts);
    failure = step.failure;
  }
  double quantile(double share) {
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  }
  double fastest() const {
    double most = 0.0;
    for (std::size_t o = 0; o < engine->scene().bodies.size(); ++o) {
      const auto v = engine->velocity(o), w = engine->angular_velocity(o);
      const Sphere& sphere = engine->scene().scene.objects[o].tree.nodes()[0].sphere_O;
      if (v && w) most = std::max(most, norm(*v) + norm(*w) * (norm(sphere.centre) + sphere.radius));
    }
    return most;
  }
};

void run(const EngineRegistry& engines, const std::string& name, const DynamicScene& scene, double seconds) {
  World worlds[2];
  const char* const checks[2] = {"own", "native"};
  try {
    for (int i = 0; i < 2; ++i) worlds[i].engine = engines.make({name, checks[i]}, scene);
  } catch (const std::exception& error) {
    std::printf("| %s | %s |\n", name.c_str(), error.what());
    return;
  }
  const auto goes_on = [&](const World& world) {
    return !world.engine->is_over() && world.failure.empty() && world.spent < 0.5e6 * seconds;
  };
  for (int turn = 0; goes_on(worlds[0]) && goes_on(worlds[1]); ++turn)
    for (int i = 0; i < 2; ++i) worlds[(i + turn) % 2].step();
  for (int i = 0; i < 2; ++i) {
    World& world = worlds[i];
    const std::size_t steps = world.times.size();
    std::printf("| %s | %s | %.1f | %.1f | %.1f | %.2f | %.0f | %.1e | %.1e | %s%s |\n", name.c_str(),
                checks[i], world.quantile(0.5), world.quantile(0.999), world.quantile(1.0),
                world.quantile(0.5) / worlds[0].quantile(0.5), world.contacts / static_cast<double>(steps),
                world.fastest(), world.engine->worst_depth(), world.failure.c_str(),
                world.engine->is_over() ? "" : (" CUT after " + std::to_string(steps) + " steps").c_str());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "engine_checks_benchmark SCENE.yaml [ENGINES [SECONDS [PARAMETER=FIGURE]...]]\n");
    return 2;
  }
  // Everything by name, then the scene with its parameters as asked for.
  BackendRegistry backends;
  register_all_backends(backends);
  EngineRegistry engines;
  physics::register_all_engines(engines, backends);
  SceneParameters parameters;
  std::string changed;
  for (int i = 4; i < argc; ++i) {
    const std::string text = argv[i];
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) throw InputError("no PARAMETER=FIGURE: '" + text + "'");
    char* end = nullptr;
    const double figure = std::strtod(text.c_str() + equals + 1, &end);
    if (*end != '\0' || end == text.c_str() + equals + 1) throw InputError("no figure: '" + text + "'");
    parameters[text.substr(0, equals)] = figure;
    changed += ", `" + text + "`";
  }
  const DynamicScene scene = load_dynamic_scene(argv[1], parameters);
  // One table, a pair of rows an engine.
  const std::string wanted = argc > 2 ? "," + std::string(argv[2]) + "," : "";
  const double seconds = argc > 3 ? std::atof(argv[3]) : 60.0;
  std::printf(
      "%s%s\n\n| engine | check | median [us] | 99.9 %% | most | over own | contacts | at the end [m/s] | "
      "deep [m] | |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      scene.scene.name.c_str(), changed.c_str());
  for (const auto& entry : engines.engines()) {
    const bool is_wanted = wanted.empty() || wanted.find("," + entry.name + ",") != std::string::npos;
    if (entry.name != "own" && is_wanted) run(engines, entry.name, scene, seconds);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "engine_checks_benchmark: %s\n", error.what());
  return 1;
}
