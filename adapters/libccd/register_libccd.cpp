#include "touchstone/adapters/libccd/libccd.hpp"
#include "touchstone/adapters/libccd/libccd_narrowphase.hpp"

namespace touchstone {

void register_libccd(BackendRegistry& registry) {
  using libccd::Method;
  const auto add = [&](const char* name, const char* description, Method method) {
    registry.add(BackendRegistry::NarrowphaseEntry{name, description,
                                                   [method] { return libccd::make_narrowphase(method); },
                                                   [method] { return libccd::make_raw_check(method); }});
  };
  add("libccd_gjk", "libccd, double precision: GJK", Method::gjk);
  add("libccd_mpr", "libccd, double precision: Minkowski Portal Refinement", Method::mpr);
}

}  // namespace touchstone
