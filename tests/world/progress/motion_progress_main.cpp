// motion_progress [SEED [TRIALS [GAP [SCENE ...]]]] [--frozen] [--page FILE]: how far movers get
// (motion_progress.hpp), TRIALS (4) of each scene at 10 Hz, 50 Hz and 1 kHz from SEED (1) on, at a contact
// gap of GAP (1e-7) m. A SCENE is a name, or NAME:TRIALS, or NAME:TRIALS:HZ. Exit code 1 where two solids
// touch.

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/tests/world/progress/motion_progress.hpp"
#include "touchstone/tests/world/progress/progress_page.hpp"

namespace touchstone {
namespace {

struct Options {
  ProgressRun run;
  std::vector<std::string> scenes;
  std::string page;
  bool shows_frozen = false;
};

/// The runs of one SCENE argument.
std::vector<ProgressRun> runs_of(const ProgressRun& common, const std::string& scene) {
  ProgressRun run = common;
  std::vector<double> rates{10.0, 50.0, 1000.0};
  const std::size_t trials = scene.find(':'),
                    rate = trials == scene.npos ? trials : scene.find(':', trials + 1);
  run.scene = scene.substr(0, trials);
  try {
    if (trials != scene.npos) run.trials = std::stoi(scene.substr(trials + 1));
    if (rate != scene.npos) rates = {std::stod(scene.substr(rate + 1))};
  } catch (const std::logic_error&) {
    throw InputError("scene '" + scene + "' is not NAME, NAME:TRIALS or NAME:TRIALS:HZ");
  }
  std::vector<ProgressRun> out;
  for (const double hz : rates) out.push_back(run), out.back().rate = hz;
  return out;
}

std::string command_of(int argc, char** argv) {
  std::string out = "motion_progress";
  for (int i = 1; i < argc; ++i) out += std::string(" ") + argv[i];
  return out;
}

int measure(const Options& options, const std::string& command) {
  std::vector<ProgressFigures> figures;
  print_progress_heading(std::cout);
  for (const std::string& scene : options.scenes)
    for (const ProgressRun& run : runs_of(options.run, scene)) {
      figures.push_back(measure_progress(run));
      print_progress(std::cout, figures.back());
      if (options.shows_frozen) print_frozen(std::cout, figures.back());
    }
  if (!options.page.empty()) {
    std::ofstream page(options.page);
    page << progress_page(figures, command) << std::flush;
    if (!page) throw InputError("'" + options.page + "' cannot be written");
  }
  for (const ProgressFigures& each : figures)
    if (each.merged > 0) return EXIT_FAILURE;
  return EXIT_SUCCESS;
}

int run(int argc, char** argv) {
  Options options;
  options.run.trials = 4;
  options.scenes.assign(progress_scenes().begin(), progress_scenes().end());
  CLI::App app("How far movers get where contacts hold them back.", "motion_progress");
  app.add_option("SEED", options.run.seed, "of the first trial");
  app.add_option("TRIALS", options.run.trials, "of each scene and rate")->check(CLI::PositiveNumber);
  app.add_option("GAP", options.run.gap, "contact gap [m]")->check(CLI::PositiveNumber);
  app.add_option("SCENE", options.scenes, "NAME, NAME:TRIALS or NAME:TRIALS:HZ");
  app.add_flag("--frozen", options.shows_frozen, "list each frozen frame, too");
  app.add_option("--page", options.page, "write the figures as Markdown, too");
  if (!program::parse_command_line(app, argc, argv)) return EXIT_SUCCESS;
  return measure(options, command_of(argc, argv));
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  return touchstone::program::run_program("motion_progress", [&] { return touchstone::run(argc, argv); });
}
