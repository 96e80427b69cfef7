#include "contact_core/native/native.hpp"
#include "contact_core/registry.hpp"

namespace touchstone {

void register_core(BackendRegistry& registry) { register_native(registry); }

}  // namespace touchstone
