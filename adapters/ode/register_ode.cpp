#include <string>

#include "touchstone/adapters/ode/ode.hpp"
#include "touchstone/adapters/ode/ode_broadphase.hpp"
#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/adapters/ode/ode_narrowphase.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

void register_ode(BackendRegistry& registry) {
  if (dCheckConfiguration("ODE_double_precision") != 1) {
    throw InputError("ode: the ODE library loaded is not a double-precision build");
  }
  const std::string version = std::string("ODE ") + dODE_VERSION + ", double precision: ";
  registry.add(BackendRegistry::NarrowphaseEntry{
      "ode", version + "dBoxBox for boxes, dCollide on dConvex (libccd MPR) for other hexahedra",
      ode::make_narrowphase, ode::make_raw_check});
  registry.add(BackendRegistry::BroadphaseEntry{"ode", version + "dSAPSpace", ode::make_broadphase});
}

}  // namespace touchstone
