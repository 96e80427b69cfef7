// motion_progress [SEED [TRIALS [GAP [SCENE ...]]]]: how far movers get (motion_progress.hpp), TRIALS (4) of
// each scene at 10 Hz, 50 Hz and 1 kHz from SEED (1) on, at a contact gap of GAP (1e-7) m. Exit code 1 where
// two solids touch.

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "motion_progress.hpp"

int main(int argc, char** argv) {
  using namespace touchstone;
  try {
    ProgressRun run;
    run.seed = argc > 1 ? std::stoull(argv[1]) : 1;
    run.trials = argc > 2 ? std::stoi(argv[2]) : 4;
    run.gap = argc > 3 ? std::stod(argv[3]) : 1e-7;
    std::vector<std::string> scenes(argv + std::min(argc, 4), argv + argc);
    if (scenes.empty()) scenes.assign(progress_scenes().begin(), progress_scenes().end());
    bool merged = false;
    print_progress_heading(std::cout);
    for (const std::string& scene : scenes)
      for (const double rate : {10.0, 50.0, 1000.0}) {
        run.scene = scene, run.rate = rate;
        const ProgressFigures figures = measure_progress(run);
        merged = merged || figures.merged > 0;
        print_progress(std::cout, figures);
      }
    return merged ? EXIT_FAILURE : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << "motion_progress: " << error.what() << '\n';
    return 2;
  }
}
