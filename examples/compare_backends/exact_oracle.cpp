#include "examples/compare_backends/oracle.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "adapters/exact/contact_patch.hpp"
#include "adapters/exact/signed_distance.hpp"
#endif

namespace touchstone::comparison {

#ifndef TOUCHSTONE_HAS_EXACT
std::unique_ptr<Oracle> make_exact_oracle() { return nullptr; }
#endif

}  // namespace touchstone::comparison
