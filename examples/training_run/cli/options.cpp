#include "touchstone/examples/training_run/cli/options.hpp"

#include <CLI/CLI.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/options/choices.hpp"
#include "touchstone/examples/program/terminal/program.hpp"

namespace touchstone::training {
std::optional<Options> parse_options(int argc, const char* const* argv,
                                     const std::filesystem::path& scripts) {
  Options options;
  options.scripts = scripts;
  CLI::App app{
      "Flies the training scenes from hand-controller scripts by four methods: no check, contact known 100 "
      "ms late (the paper's Figure 1), whole steps refused by the paper's own check (Figure 2, its first "
      "build), and the contact world; judged by exact."};
  // Scripts and backends are chosen by name.
  app.add_option("--scene", options.scenes,
                 "Scene numbers (1 10), script names or script files (default: all; --list names them)");
  app.add_option("--backend", options.backends,
                 "Narrowphases of the contact world (default: native; 'all' for every one)");
  auto* rate =
      app.add_option("--rate", options.frame_rate, "Frames a second, 10 to 1000 (default: the script's)");
  // Records, animations and images are left out unless they are asked for.
  app.add_option("--record", options.outputs.records, "Folder of records of all flights (CSV)");
  app.add_option("--gltf", options.outputs.animations, "Folder of animations made from the records");
  app.add_option("--cigi", options.outputs.cigi,
                 "HOST:PORT of an image generator, for the contact world's flights with the first backend, "
                 "in real time");
  app.add_option("--out,--output", options.output, "Folder of results and plots")->capture_default_str();
  std::string folder;
  app.add_option("--scripts", folder, "Folder with the scripts");
  robot_files::add_robot_options(app, options.robots);
  app.add_flag("--list", options.list, "List scripts and backends");
  if (!program::parse_command_line(app, argc, argv)) return std::nullopt;
  // Figures are checked and defaults set once all options are known.
  if (*rate && !(options.frame_rate >= 10.0 && options.frame_rate <= 1000.0))
    throw InputError("--rate: is not within 10 and 1000 Hz");
  if (options.output.empty()) throw InputError("--out: names no folder");
  if (!folder.empty()) options.scripts = folder;
  if (options.backends.empty()) options.backends = {"native"};
  return options;
}

std::vector<std::filesystem::path> find_scripts(const Options& options) {
  std::vector<std::filesystem::path> files;
  if (options.robots.files.empty() || !options.scenes.empty())
    files = program::choose_files({options.scripts, "--scripts", "no script flies it"}, options.scenes);
  files.insert(files.end(), options.robots.files.begin(), options.robots.files.end());
  return files;
}

}  // namespace touchstone::training
