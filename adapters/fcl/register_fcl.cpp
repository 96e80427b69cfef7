#include <fcl/config.h>

#include <string>

#include "touchstone/adapters/fcl/fcl.hpp"
#include "touchstone/adapters/fcl/fcl_narrowphase.hpp"

namespace touchstone {

void register_fcl(BackendRegistry& registry) {
  using fcl_adapter::Solver;
  const auto add = [&](const char* name, const char* solver, Solver which) {
    registry.add(BackendRegistry::NarrowphaseEntry{
        name, std::string("FCL ") + FCL_VERSION + ", double precision: " + solver,
        [which] { return fcl_adapter::make_narrowphase(which); },
        [which] { return fcl_adapter::make_raw_check(which); }});
  };
  add("fcl", "its solver on libccd", Solver::libccd);
  add("fcl_indep", "its own GJK and EPA", Solver::indep);
}

}  // namespace touchstone
