#include "examples/compare_backends/backends.hpp"
#include "tests/backend_suite/suite.hpp"

namespace touchstone::suite {

// Those of this process: the single-precision Bullet answers from a program of its own, and has a suite of
// its own.
void register_suite_backends(BackendRegistry& registry) {
  registry = comparison::build_backends({}).registry;
}

}  // namespace touchstone::suite
