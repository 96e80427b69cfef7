#include <fcl/config.h>

#include <string>

#include "touchstone/adapters/fcl/fcl.hpp"
#include "touchstone/adapters/fcl/fcl_narrowphase.hpp"
#include "touchstone/adapters/fcl/fcl_sweep.hpp"

namespace touchstone {
namespace {

std::string describe(const char* what) {
  return std::string("FCL ") + FCL_VERSION + ", double precision: " + what;
}

SweepEntry sweep_entry(const char* name, const char* what, const fcl_adapter::SweepSetting& setting) {
  return {name, describe(what), "fcl_indep", [=] { return fcl_adapter::make_sweep(setting); }};
}

}  // namespace

void register_fcl(BackendRegistry& registry) {
  using fcl_adapter::Solver;
  const auto add = [&](const char* name, const char* solver, Solver which) {
    registry.add(BackendRegistry::NarrowphaseEntry{name, describe(solver),
                                                   [which] { return fcl_adapter::make_narrowphase(which); },
                                                   [which] { return fcl_adapter::make_raw_check(which); }});
  };
  add("fcl", "its solver on libccd", Solver::libccd);
  add("fcl_indep", "its own GJK and EPA", Solver::indep);
}

std::vector<SweepEntry> fcl_sweeps() {
  return {sweep_entry("fcl_ca", "conservative advancement, GST_LIBCCD",
                      {fcl::CCDC_CONSERVATIVE_ADVANCEMENT, fcl::GST_LIBCCD}),
          sweep_entry("fcl_indep_ca", "conservative advancement, GST_INDEP",
                      {fcl::CCDC_CONSERVATIVE_ADVANCEMENT, fcl::GST_INDEP}),
          sweep_entry("fcl_naive", "CCDC_NAIVE, 10 poses (its default)", {fcl::CCDC_NAIVE, fcl::GST_LIBCCD})};
}

}  // namespace touchstone
