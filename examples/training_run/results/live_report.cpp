#include "touchstone/examples/training_run/results/live_report.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::training {
namespace {

std::string plot_name(const std::string& script) { return "plots/" + script + ".svg"; }

/// All that a run may write. @throws InputError for two scripts whose files would have one name.
std::vector<std::string> names_of(const std::vector<std::string>& scripts) {
  std::vector<std::string> names = {"results.json", "results.csv"};
  for (auto script = scripts.begin(); script != scripts.end(); ++script) {
    if (std::find(scripts.begin(), script, *script) != script)
      throw InputError("--scene: '" + *script + "' is given twice");
    names.push_back(plot_name(*script));
  }
  return names;
}

}  // namespace

LiveReport::LiveReport(const std::string& folder, std::vector<std::string> scripts)
    : scripts_(std::move(scripts)), report_(folder, names_of(scripts_)) {}

void LiveReport::put_tables(std::size_t done) {
  const std::vector<std::string> missing(scripts_.begin() + static_cast<std::ptrdiff_t>(done),
                                         scripts_.end());
  report_.put(
      {{"results.json", results_json(results_, missing)}, {"results.csv", results_csv(results_, missing)}});
}

void LiveReport::see_method(const ScriptResult& so_far) {
  const std::size_t done = results_.size();
  results_.push_back(so_far);
  put_tables(done);
  results_.pop_back();
}

void LiveReport::see_script(ScriptResult result) {
  const std::string plot = separation_plot(result);
  if (!plot.empty()) report_.put({{plot_name(result.file), plot}});
  results_.push_back(std::move(result));
  if (results_.size() < scripts_.size()) put_tables(results_.size());
}

void LiveReport::finish() {
  report_.finish({{"results.json", results_json(results_)}, {"results.csv", results_csv(results_)}});
}

}  // namespace touchstone::training
