#include "touchstone/examples/dynamics_run/run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#include "touchstone/examples/dynamics_run/simulate.hpp"

namespace touchstone::dynamics {

SceneResult run_scene(const std::filesystem::path& file, const Options& options,
                      const BackendRegistry& registry, const std::vector<std::string>& backends,
                      comparison::ProgressLine& progress) {
  SceneParameters parameters;
  for (const comparison::SceneSetting& setting : options.settings) parameters[setting.name] = setting.value;
  SceneResult result;
  result.file = file.stem().string();
  result.scene = std::make_shared<const physics::DynamicScene>(load_dynamic_scene(file, parameters));
  check(*result.scene, registry);
  result.solid_names = solid_names(*result.scene);
  result.reference = options.reference;
  std::vector<std::string> names = backends;
  const bool is_asked = std::find(names.begin(), names.end(), options.reference) != names.end();
  if (!is_asked) names.push_back(options.reference);
  for (const std::string& name : names) {
    progress.step(fmt::format("{}: {}", result.file, name));
    const bool is_shown = is_asked || name != options.reference;
    result.runs.push_back(simulate(*result.scene, registry, name, is_shown ? options.every : 0, progress));
  }
  // In turns, so that a busy machine is busy for all.
  for (int i = 1; i < options.repetitions; ++i)
    for (BackendRun& run : result.runs) {
      progress.step(fmt::format("{}: {}, once more", result.file, run.backend));
      repeat_timing(*result.scene, registry, run, progress);
    }
  judge(result);
  return result;
}

std::vector<comparison::ReportFile> report_files(const std::vector<SceneResult>& results) {
  std::vector<comparison::ReportFile> files = {{"results.json", results_json(results)},
                                               {"results.csv", results_csv(results)}};
  for (const SceneResult& result : results) {
    for (const BackendRun& run : result.runs) {
      if (run.series.samples.empty()) continue;
      files.emplace_back(fmt::format("series/{}.{}.csv", result.file, run.backend), series_csv(result, run));
      files.emplace_back(fmt::format("contacts/{}.{}.csv", result.file, run.backend),
                         contacts_csv(result, run));
    }
    const std::string plot = time_plot(result);
    if (!plot.empty()) files.emplace_back("plots/" + result.file + ".svg", plot);
  }
  return files;
}

}  // namespace touchstone::dynamics
