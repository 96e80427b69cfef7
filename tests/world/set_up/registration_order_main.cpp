// registration_order [SEED [WORLDS]]: edited_worlds.hpp's worlds (1 000) of seeds from SEED (1) on. Exit code
// 1 where any differs.

#include <cstdlib>
#include <iostream>
#include <string>

#include "touchstone/tests/world/set_up/edited_worlds.hpp"

int main(int argc, char** argv) {
  using namespace touchstone;
  try {
    const std::uint64_t seed = argc > 1 ? std::stoull(argv[1]) : 1;
    const OrderFigures figures = fly_edited_worlds(seed, argc > 2 ? std::stoull(argv[2]) : 1000);
    print(std::cout, figures);
    return figures.findings.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::cerr << "registration_order: " << error.what() << '\n';
    return 2;
  }
}
