// motion_proof [--rounded] [--seed SEED] [MOTIONS [NARROWPHASE ...]]: MOTIONS random motions (100 000), drawn
// from SEED (1), with each narrowphase (native), judged by `exact`; --rounded: of solids most of which have a
// radius. Exit code 1 where native or exact has a violation; those of others are counted.

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/world/flown/motion_proof.hpp"

int main(int argc, char** argv) {
  using namespace touchstone;
  try {
    // Solids, seed, motions and backends come from the command line, in this order.
    std::vector<std::string> names(argv + 1, argv + argc);
    std::uint64_t motions = 100000, seed = 1;
    const bool rounded = !names.empty() && names[0] == "--rounded";
    if (rounded) names.erase(names.begin());
    if (names.size() > 1 && names[0] == "--seed") {
      seed = std::stoull(names[1]);
      names.erase(names.begin(), names.begin() + 2);
    }
    if (!names.empty()) {
      motions = std::stoull(names[0]);
      names.erase(names.begin());
    }
    if (names.empty()) names = {"native"};
    // Each backend; a violation of one that proves its motions is a failure.
    std::vector<MotionFigures> figures;
    bool violated = false;
    for (const std::string& name : names) {
      figures.push_back(prove_motions({name, "native", motions, seed, rounded}));
      violated = violated || ((name == "native" || name == "exact") && figures.back().violations() > 0);
    }
    print_table(std::cout, figures);
    return violated ? EXIT_FAILURE : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::cerr << "motion_proof: " << error.what() << '\n';
    return 2;
  }
}
