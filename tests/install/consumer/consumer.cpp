// What a user of the installed package writes: two boxes, one query, every installed backend by name.
#include <array>
#include <cstdio>
#include <exception>

#include "contact_core/registry.hpp"
#ifdef WITH_exact
#include "adapters/exact/exact.hpp"
#endif
#ifdef WITH_bullet
#include "adapters/bullet/bullet.hpp"
#endif
#ifdef WITH_ode
#include "adapters/ode/ode.hpp"
#endif
#ifdef WITH_libccd
#include "adapters/libccd/libccd.hpp"
#endif
#ifdef WITH_fcl
#include "adapters/fcl/fcl.hpp"
#endif
#ifdef WITH_mujoco
#include "adapters/mujoco/mujoco.hpp"
#endif

using namespace touchstone;

int main() try {
  BackendRegistry registry;
  register_core(registry);
#ifdef WITH_exact
  register_exact(registry);
#endif
#ifdef WITH_bullet
  register_bullet(registry);
#endif
#ifdef WITH_ode
  register_ode(registry);
#endif
#ifdef WITH_libccd
  register_libccd(registry);
#endif
#ifdef WITH_fcl
  register_fcl(registry);
#endif
#ifdef WITH_mujoco
  register_mujoco(registry);
#endif

  const std::array solids = {Hexahedron::from_size({2.0, 2.0, 2.0}), Hexahedron::from_size({1.0, 1.0, 1.0})};
  std::array<Pose, 2> poses;
  poses[1].p = {1.25, 0.0, 0.0};  // a quarter of a metre deep
  const std::array pairs = {SolidPair{0, 1}};

  int wrong = 0;
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases()) {
    const std::unique_ptr<Narrowphase> narrowphase = entry.make();
    narrowphase->build(solids);
    const std::unique_ptr<Narrowphase::Workspace> workspace = narrowphase->make_workspace();
    std::array<PairStatus, 1> status;
    std::array<PairGeometry, 1> geometry;
    narrowphase->evaluate({.pairs = pairs, .poses = poses, .query = {}},
                          {.status = status, .geometry = geometry}, *workspace);
    std::printf("%-12s %s\n", entry.name.c_str(), to_string(status[0]).data());
    if (status[0] != PairStatus::overlapping) ++wrong;
  }
  return registry.narrowphases().empty() || wrong != 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
