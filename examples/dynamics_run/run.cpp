#include "touchstone/examples/dynamics_run/run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/dynamics_run/robot_scene.hpp"
#include "touchstone/examples/dynamics_run/simulate.hpp"

namespace touchstone::dynamics {
namespace {

/// Of a run: two times a step are kept until all backends have run; of a recorded one, some hundred bytes an
/// object.
constexpr double kMostSteps = 1e7, kMostRecorded = 2e6;

void check_length(const std::filesystem::path& file, const physics::DynamicScene& scene, std::size_t every) {
  const double steps = scene.scene.duration / scene.step;
  if (!(steps <= kMostSteps))
    throw InputError(fmt::format("{}: a duration of {} s is {:.3g} steps of {} s, more than {:.0e}",
                                 file.string(), scene.scene.duration, steps, scene.step, kMostSteps));
  const auto rows = static_cast<double>(scene.scene.objects.size() + moving_joints(scene).size());
  if (!(steps / static_cast<double>(every) * rows <= kMostRecorded))
    throw InputError(
        fmt::format("{}: {:.3g} steps of {} objects and joints are more to record than {:.0e}; record "
                    "every n-th step (--every)",
                    file.string(), steps, rows, kMostRecorded));
}

physics::DynamicScene read_scene(const std::filesystem::path& file, const Options& options,
                                 const std::function<void(const std::string&)>& on_account) {
  if (is_robot_file(file)) {
    const Robot robot = robot_files::load_robot_file(file, options.robots);
    if (on_account) on_account(robot_files::account_of(robot));
    return robot_scene(robot.mechanism);
  }
  SceneParameters parameters;
  for (const program::SceneSetting& setting : options.settings) parameters[setting.name] = setting.value;
  return load_dynamic_scene(file, parameters, robot_files::arm_models(options.robots, on_account));
}

/// Of every figure that a run is judged by, in its unit; energy made and drifts are shares.
void allow(double error, physics::DynamicScene& scene) {
  for (physics::SceneAnswer& answer : scene.answers) answer.tolerance = std::max(answer.tolerance, error);
  physics::SceneAccept& accept = scene.accept;
  for (double* const limit :
       {&accept.depth, &accept.position, &accept.angle, &accept.energy_made, &accept.drift, &accept.rest})
    *limit = std::max(*limit, error);
}

}  // namespace

physics::DynamicScene load_scene(const std::filesystem::path& file, const Options& options,
                                 const std::function<void(const std::string&)>& on_account) {
  physics::DynamicScene scene = read_scene(file, options, on_account);
  check_length(file, scene, options.every);
  if (options.error > 0.0) allow(options.error, scene);
  return scene;
}

SceneResult run_scene(const std::filesystem::path& file, const Options& options,
                      const physics::EngineRegistry& engines,
                      const std::vector<physics::EngineChoice>& choices, program::ProgressLine& progress,
                      const OnRun& on_run) {
  SceneResult result;
  result.file = file.stem().string();
  result.scene = std::make_shared<const physics::DynamicScene>(load_scene(file, options));
  check(*result.scene, engines);
  result.solid_names = solid_names(*result.scene);
  result.reference = options.reference;
  result.deadline_us = 1e6 * (options.deadline > 0.0 ? options.deadline : result.scene->step);
  std::vector<physics::EngineChoice> all = choices;
  const bool is_asked = std::any_of(choices.begin(), choices.end(), [&](const physics::EngineChoice& choice) {
    return run_name(choice) == options.reference;
  });
  if (!is_asked && compares_poses(*result.scene)) all.push_back({"own", options.reference});
  for (const physics::EngineChoice& choice : all) {
    const std::string name = run_name(choice);
    progress.step(fmt::format("{}: {}", result.file, name));
    const bool is_shown = is_asked || name != options.reference;
    result.runs.push_back(simulate(*result.scene, engines, choice, is_shown ? options.every : 0, progress));
    if (on_run) on_run(result);
  }
  // In turns, so that a busy machine is busy for all.
  for (int i = 1; i < options.repetitions; ++i)
    for (std::size_t r = 0; r < all.size(); ++r) {
      progress.step(fmt::format("{}: {}, once more", result.file, result.runs[r].backend));
      repeat_timing(*result.scene, engines, all[r], result.runs[r], progress);
    }
  judge(result);
  return result;
}

}  // namespace touchstone::dynamics
