#include <iostream>

#include "touchstone/adapters/plugin/plugin.hpp"
#include "touchstone/examples/compare_backends/run/workers/worker.hpp"

// The first argument is the library, the others are a worker's.
int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "a worker of compare_backends: it is started by that program\n";
    return 2;
  }
  return touchstone::comparison::worker_main(argc - 1, argv + 1, [&](touchstone::BackendRegistry& registry) {
    touchstone::register_plugin(registry, argv[1]);
  });
}
