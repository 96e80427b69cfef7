#include "touchstone/examples/dynamics_run/live_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::dynamics {
namespace {

using program::ReportFile;

/// `bullet:native` as bullet_native: a colon is no file name everywhere.
std::string in_file(std::string run) {
  std::replace(run.begin(), run.end(), ':', '_');
  return run;
}
std::string series_name(const std::string& scene, const std::string& run) {
  return fmt::format("series/{}.{}.csv", scene, in_file(run));
}
std::string contacts_name(const std::string& scene, const std::string& run) {
  return fmt::format("contacts/{}.{}.csv", scene, in_file(run));
}
std::string plot_name(const std::string& scene) { return "plots/" + scene + ".svg"; }

/// All that a run may write. @throws InputError for two scenes whose files would have one name.
std::vector<std::string> names_of(const std::vector<std::string>& scenes,
                                  const std::vector<std::string>& backends) {
  std::vector<std::string> names = {"results.json", "results.csv"};
  for (auto scene = scenes.begin(); scene != scenes.end(); ++scene) {
    if (std::find(scenes.begin(), scene, *scene) != scene)
      throw InputError("--scene: '" + *scene + "' is given twice");
    names.push_back(plot_name(*scene));
    for (const std::string& backend : backends) {
      names.push_back(series_name(*scene, backend));
      names.push_back(contacts_name(*scene, backend));
    }
  }
  return names;
}

std::vector<ReportFile> recorded(const SceneResult& result, const BackendRun& run) {
  if (run.series.samples.empty()) return {};
  return {{series_name(result.file, run.backend), series_csv(result, run)},
          {contacts_name(result.file, run.backend), contacts_csv(result, run)}};
}

}  // namespace

LiveReport::LiveReport(const std::string& folder, std::vector<std::string> scenes,
                       std::vector<std::string> backends)
    : scenes_(std::move(scenes)),
      backends_(std::move(backends)),
      report_(folder, names_of(scenes_, backends_)) {}

std::vector<std::string> LiveReport::not_measured(const SceneResult* current) const {
  std::vector<std::string> names;
  std::size_t done = results_.size();
  if (current != nullptr) {
    for (const std::string& backend : backends_)
      if (std::none_of(current->runs.begin(), current->runs.end(),
                       [&](const BackendRun& run) { return run.backend == backend; }))
        names.push_back(current->file + "/" + backend);
    // Even where every backend has run once the scene has no verdict yet.
    if (names.empty()) names.push_back(current->file + "/repetitions");
    ++done;
  }
  names.insert(names.end(), scenes_.begin() + static_cast<std::ptrdiff_t>(done), scenes_.end());
  return names;
}

void LiveReport::put_tables(const std::vector<std::string>& not_measured) {
  report_.put({{"results.json", results_json(results_, not_measured)},
               {"results.csv", results_csv(results_, not_measured)}});
}

void LiveReport::see_run(const SceneResult& so_far) {
  report_.put(recorded(so_far, so_far.runs.back()));
  SceneResult open = so_far;
  judge(open);
  open.recommended.clear();
  open.reason = "the run ended before this scene was done";
  const std::vector<std::string> missing = not_measured(&open);
  results_.push_back(std::move(open));
  put_tables(missing);
  results_.pop_back();
}

void LiveReport::see_scene(SceneResult result) {
  const std::string plot = time_plot(result);
  if (!plot.empty()) report_.put({{plot_name(result.file), plot}});
  results_.push_back(std::move(result));
  if (results_.size() < scenes_.size()) put_tables(not_measured(nullptr));
}

std::string LiveReport::verdict() const {
  if (results_.size() < 2) return "";
  return terminal_text(choose_over_all(results_), results_.size());
}

void LiveReport::finish() {
  report_.finish({{"results.json", results_json(results_)}, {"results.csv", results_csv(results_)}});
}

}  // namespace touchstone::dynamics
