#include "contact_core/registry.hpp"

namespace touchstone {

void register_core(BackendRegistry& registry) { (void)registry; }

}  // namespace touchstone
