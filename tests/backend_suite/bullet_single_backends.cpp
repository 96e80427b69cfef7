#include "touchstone/adapters/bullet/bullet_single.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

namespace touchstone::suite {

void register_suite_backends(BackendRegistry& registry) { register_bullet_single(registry); }

}  // namespace touchstone::suite
