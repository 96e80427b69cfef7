#include "touchstone/adapters/all/all_backends.hpp"

#include "touchstone/tests/backend_suite/suite.hpp"

namespace touchstone::suite {

// Those of this process: the single-precision Bullet has a suite of its own.
void register_suite_backends(BackendRegistry& registry) { register_all_backends(registry); }

}  // namespace touchstone::suite
