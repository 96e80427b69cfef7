#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/adapters/scene_files/pair_capture.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/world/scene_world.hpp"
#include "touchstone/examples/bench/capture/observed_narrowphase.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/training_run/flight/contact_world_method.hpp"
#include "touchstone/examples/training_run/flight/fly.hpp"
#include "touchstone/physics/engine/engine_registry.hpp"

// Runs the bundled scenes, scripts and dynamics with `native` and writes the pairs that it was asked about:
// the benchmark's captured pairs. A fair sample of each run, from a fixed seed.

namespace {

using namespace touchstone;
using program::print_now;
namespace fs = std::filesystem;

/// Narrowphases under this name tell their pairs.
constexpr const char* kObserved = "observed";

struct Capture {
  std::size_t most = 0;  ///< of a run
  std::vector<PairCase> cases;

  /// @param go runs something with backends, one of which tells.
  void run(const fs::path& file, const std::function<void(const BackendRegistry&)>& go) {
    PairCapture capture(most);
    BackendRegistry backends;
    register_core(backends);
    backends.add(
        {kObserved,
         "native, observed",
         [&] { return std::make_unique<ObservedNarrowphase>(backends.make_narrowphase("native"), capture); },
         {}});
    go(backends);
    for (PairCase& each : capture.cases()) {
      each.id = file.stem().string() + ":" + each.id;
      each.captured.reset();
      cases.push_back(std::move(each));
    }
    print_now(fmt::format("{}: {} pairs asked\n", file.filename().string(), capture.observed()));
  }
};

void fly_scene(const fs::path& file, Capture& capture) {
  const Scene scene = load_scene(file);
  capture.run(file, [&](const BackendRegistry& backends) {
    SceneWorld flight(scene, backends.make_narrowphase(kObserved), backends.make_broadphase("native"));
    for (std::size_t frame = 1; frame < scene.frame_count(); ++frame) flight.step();
  });
}

void fly_script(const fs::path& file, Capture& capture) {
  const training::Setting setting(load_script(file));
  capture.run(file, [&](const BackendRegistry& backends) {
    training::ContactWorldMethod method(setting, backends.make_narrowphase(kObserved),
                                        backends.make_broadphase("native"));
    training::fly(setting, method, false);
  });
}

void step_dynamics(const fs::path& file, Capture& capture) {
  const physics::DynamicScene scene = load_dynamic_scene(file);
  capture.run(file, [&](const BackendRegistry& backends) {
    physics::EngineRegistry engines;
    physics::register_own_engine(engines, backends);
    const auto engine = engines.make({"own", kObserved}, scene);
    while (!engine->is_over()) {
      engine->begin_step();
      if (const physics::EngineStep step = engine->step(); !step.failure.empty())
        throw InputError(file.string() + ": " + step.failure);
    }
  });
}

void check_free(const fs::path& output) {
  if (fs::exists(fs::symlink_status(output)))
    throw InputError(output.string() + ": is there; move it away or name another file");
}

/// Ids begin with the file's stem.
void check_stems(const std::vector<std::string>& files) {
  std::map<std::string, std::string> seen;
  for (const std::string& file : files) {
    const auto [before, is_new] = seen.emplace(fs::path(file).stem().string(), file);
    if (!is_new)
      throw InputError(file + ": has the name of " + before->second +
                       ", and its pairs would have the same ids");
  }
}

int run(int argc, const char* const* argv) {
  CLI::App app{"Runs scenes, scripts and dynamics, and writes the pairs that were asked about."};
  std::string output;
  std::vector<std::string> scenes, scripts, dynamics;
  Capture capture;
  app.add_option("FILE", output, "The pair file; it must not be there yet")->required();
  app.add_option("--scene", scenes, "Scene files, flown by a contact world along their motions");
  app.add_option("--script", scripts, "Scripts of training_run, flown by a contact world");
  app.add_option("--dynamics", dynamics, "Scene files with dynamics, stepped by our own engine");
  app.add_option("--most", capture.most, "Pairs of a run that are kept")
      ->check(CLI::Range(1, 1000000))
      ->required();
  if (!program::parse_command_line(app, argc, argv)) return 0;
  // All that can be refused is refused before the runs.
  check_free(output);
  const fs::path folder = fs::absolute(output).parent_path();
  if (!fs::is_directory(folder)) throw InputError(output + ": there is no folder " + folder.string());
  std::vector<std::string> files = scenes;
  files.insert(files.end(), scripts.begin(), scripts.end());
  files.insert(files.end(), dynamics.begin(), dynamics.end());
  check_stems(files);
  // The runs, then the file.
  for (const std::string& file : scenes) fly_scene(file, capture);
  for (const std::string& file : scripts) fly_script(file, capture);
  for (const std::string& file : dynamics) step_dynamics(file, capture);
  if (capture.cases.empty()) throw InputError("capture_pairs: no pair was asked about");
  check_free(output);  // the runs take a while
  save_pairs(output, capture.cases);
  print_now(fmt::format("{}: {} pairs\n", output, capture.cases.size()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return touchstone::program::run_program("capture_pairs", [&] { return run(argc, argv); });
}
