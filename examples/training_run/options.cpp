#include "examples/training_run/options.hpp"

#include <algorithm>
#include <cmath>

#include "contact_core/input_error.hpp"
#include "examples/program/program.hpp"

namespace touchstone::training {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> scripts_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  if (error) throw InputError("--scripts " + folder.string() + ": cannot be read");
  std::sort(files.begin(), files.end());
  return files;
}

/// "1" and "01" mean every script whose name starts with that number.
bool means(const std::string& scene, const fs::path& file) {
  const std::string name = file.stem().string();
  if (scene == name) return true;
  const std::string number = name.substr(0, name.find('_'));
  const auto without_zeros = [](const std::string& text) {
    return text.substr(std::min(text.find_first_not_of('0'), text.size()));
  };
  return without_zeros(scene) == without_zeros(number);
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, const fs::path& scripts) {
  Options options;
  options.scripts = scripts;
  CLI::App app{
      "Flies the training scenes from hand-controller scripts three ways: no check, contact known 100 ms "
      "late "
      "(the paper's Figure 1), and the contact world; judged by exact."};
  app.add_option("--scene", options.scenes,
                 "Scene numbers (1 10), script names or script files (default: all; --list names them)");
  app.add_option("--backend", options.backends,
                 "Narrowphases of the contact world (default: native; 'all' for every one)");
  auto* rate =
      app.add_option("--rate", options.frame_rate, "Frames a second, 10 to 1000 (default: the script's)");
  app.add_option("--record", options.outputs.records, "Folder of records of all flights (CSV)");
  app.add_option("--gltf", options.outputs.animations, "Folder of animations made from the records");
  app.add_option("--cigi", options.outputs.cigi,
                 "HOST:PORT of an image generator, for the contact world's flights with the first backend, "
                 "in real time");
  app.add_option("--out,--output", options.output, "Folder of results and plots")->capture_default_str();
  std::string folder;
  app.add_option("--scripts", folder, "Folder with the scripts");
  app.add_flag("--list", options.list, "List scripts and backends");
  if (!comparison::parse_command_line(app, argc, argv)) return std::nullopt;
  if (*rate && !(options.frame_rate >= 10.0 && options.frame_rate <= 1000.0))
    throw InputError("--rate: is not within 10 and 1000 Hz");
  if (options.output.empty()) throw InputError("--out: names no folder");
  if (!folder.empty()) options.scripts = folder;
  if (options.backends.empty()) options.backends = {"native"};
  return options;
}

std::vector<fs::path> find_scripts(const Options& options) {
  const std::vector<fs::path> known = scripts_in(options.scripts);
  if (options.scenes.empty()) return known;
  std::vector<fs::path> found;
  for (const std::string& scene : options.scenes) {
    const std::size_t before = found.size();
    for (const fs::path& file : known)
      if (means(scene, file)) found.push_back(file);
    if (found.size() == before && fs::path(scene).extension() == ".yaml") found.emplace_back(scene);
    if (found.size() == before)
      throw InputError("--scene " + scene + ": no script flies it; --list names them");
  }
  return found;
}

}  // namespace touchstone::training
