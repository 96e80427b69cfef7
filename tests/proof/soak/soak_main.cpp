// soak [FRAMES [SEED]]: FRAMES (1 000 000) of a contact world under random treatment; then the same again
// with the recorded selections in place of the thread, which must end with the same hash. Exit code 1: it did
// not, or an invariant broke.

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <string>

#include "touchstone/tests/proof/soak/soak.hpp"

int main(int argc, char** argv) {
  using namespace touchstone;
  try {
    Soak run;
    run.frames = argc > 1 ? std::stoull(argv[1]) : 1000000;
    run.seed = argc > 2 ? std::stoull(argv[2]) : 1;
    const auto start = std::chrono::steady_clock::now();
    const SoakFigures flown = soak(run);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    std::cout << describe(flown) << time.count() << " s\n" << std::flush;
    if (!flown.violation.empty()) return EXIT_FAILURE;
    run.replay = &flown.record;
    const SoakFigures again = soak(run);
    const bool same = again.pose_hash == flown.pose_hash && again.violation.empty();
    std::cout << (same ? "replayed from the record: the same poses\n" : "THE REPLAY DIFFERS\n");
    return same ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::cerr << "soak: " << error.what() << '\n';
    return 2;
  }
}
