#include "examples/dynamics_run/options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "contact_core/input_error.hpp"
#include "examples/program/program.hpp"

namespace touchstone::dynamics {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> scenes_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  if (error) throw InputError("--scenes " + folder.string() + ": cannot be read");
  std::sort(files.begin(), files.end());
  return files;
}

/// "8" and "08" mean every scene whose name starts with that number.
bool means(const std::string& scene, const fs::path& file) {
  const std::string name = file.stem().string();
  if (scene == name) return true;
  const auto without_zeros = [](const std::string& text) {
    return text.substr(std::min(text.find_first_not_of('0'), text.size()));
  };
  return without_zeros(scene) == without_zeros(name.substr(0, name.find('_')));
}

ParameterSetting parse_setting(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError("--set '" + text + "': expected NAME=VALUE");
  ParameterSetting setting{text.substr(0, equals), 0.0};
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + equals + 1, last, setting.value);
  if (error != std::errc() || end != last || !std::isfinite(setting.value))
    throw InputError("--set '" + text + "': the value is no finite number");
  return setting;
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, const fs::path& scenes) {
  Options options;
  options.folder = scenes;
  CLI::App app{
      "Runs scenes with dynamics over the contacts of every backend, compares drift of momentum and energy, "
      "penetration, final poses and time per step, and names the backend to build on."};
  app.add_option("--scene", options.scenes,
                 "Scene numbers (8 9), names or files (default: all bundled ones; --list names them)");
  app.add_option("--backend", options.backends, "Narrowphases (default: all; --list names them)");
  app.add_option("--reference", options.reference,
                 "What final poses are compared with (default: exact, or native where that is not built)");
  std::vector<std::string> settings;
  app.add_option("--set", settings,
                 "Scene parameters, NAME=VALUE; what the scene is known to come to is not judged then");
  app.add_option("--every", options.every, "Record the start, every n-th step and the last")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions,
                 "Runs of each scene and backend: a step's time is that of its fastest")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--out,--output", options.output, "Folder of results, series and plots")
      ->capture_default_str();
  std::string folder;
  app.add_option("--scenes", folder, "Folder with the scenes");
  app.add_flag("--list", options.list, "List scenes and backends");
  if (!comparison::parse_command_line(app, argc, argv)) return std::nullopt;
  for (const std::string& setting : settings) options.settings.push_back(parse_setting(setting));
  if (options.output.empty()) throw InputError("--out: names no folder");
  if (!folder.empty()) options.folder = folder;
  if (options.backends.empty()) options.backends = {"all"};
  return options;
}

std::vector<fs::path> find_scenes(const Options& options) {
  const std::vector<fs::path> known = scenes_in(options.folder);
  if (options.scenes.empty()) return known;
  std::vector<fs::path> found;
  for (const std::string& scene : options.scenes) {
    const std::size_t before = found.size();
    for (const fs::path& file : known)
      if (means(scene, file)) found.push_back(file);
    if (found.size() == before && fs::path(scene).extension() == ".yaml") found.emplace_back(scene);
    if (found.size() == before)
      throw InputError("--scene " + scene + ": there is no such scene; --list names them");
  }
  return found;
}

}  // namespace touchstone::dynamics
