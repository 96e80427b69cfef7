// motion_proof [MOTIONS [NARROWPHASE ...]]: MOTIONS random motions (100 000) with each narrowphase (native),
// judged by `exact`. Exit code 1 where native or exact has a violation; those of others are counted.

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "motion_proof.hpp"
#include "touchstone/contact_core/input_error.hpp"

int main(int argc, char** argv) {
  using namespace touchstone;
  try {
    const std::uint64_t motions = argc > 1 ? std::stoull(argv[1]) : 100000;
    std::vector<std::string> names(argv + std::min(argc, 2), argv + argc);
    if (names.empty()) names = {"native"};
    std::vector<MotionFigures> figures;
    bool violated = false;
    for (const std::string& name : names) {
      figures.push_back(prove_motions({name, "native", motions, 1}));
      violated = violated || ((name == "native" || name == "exact") && figures.back().violations() > 0);
    }
    print_table(std::cout, figures);
    return violated ? EXIT_FAILURE : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << "motion_proof: " << error.what() << '\n';
    return 2;
  }
}
