#include "touchstone/examples/compare_backends/run/replay_command.hpp"

#include <fmt/format.h>

#include "touchstone/examples/program/options/shell_text.hpp"

namespace touchstone::comparison {

std::string replay_command(const Report& report, const std::string& set, const std::string& id) {
  // An id that starts with a dash would be read as an option.
  const std::string command =
      std::string("examples/run --case") + (id.starts_with('-') ? "=" : " ") + shell_word(id);
  if (report.pair_file && report.pair_file->cases.set.name == set)
    return command + " --pairs " + shell_word(report.pair_file->cases.file);
  if (report.corpus)
    for (const CorpusSet& each : report.corpus->sets)
      if (each.name == set) return command + " --corpus " + shell_word(report.corpus->folder);
  for (const SceneResult& scene : report.scenes) {
    if (scene.name != set) continue;
    std::string text = command + " --scene " + shell_word(scene.file);
    if (!scene.parameters.empty()) text += " --set";
    for (const auto& [name, value] : scene.parameters)
      text += " " + shell_word(fmt::format("{}={}", name, value));
    return text;
  }
  return fmt::format("{} --seed {}", command, report.options.seed);
}

}  // namespace touchstone::comparison
