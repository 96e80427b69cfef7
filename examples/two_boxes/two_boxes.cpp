// The library in twenty lines: how far are two boxes apart, and where do they touch?
#include <array>
#include <cstdio>

#include "touchstone/contact_core/registry.hpp"

using namespace touchstone;

int main() {
  BackendRegistry registry;
  register_core(registry);  // register_bullet(registry), register_ode(registry), ... where they are linked
  const auto narrowphase = registry.make_narrowphase("native");  // the backend is this one word

  const std::array solids = {Hexahedron::from_size({2, 2, 2}), Hexahedron::from_size({1, 1, 1})};  // [m]
  narrowphase->build(solids);                                                                      // once
  const auto workspace = narrowphase->make_workspace();  // one a thread

  std::array<Pose, 2> poses;  // X_WS of each solid, every frame
  poses[1].p = {1.25, 0, 0};
  const std::array pairs = {SolidPair{0, 1}};
  std::array<PairStatus, 1> status;
  std::array<PairGeometry, 1> geometry;
  narrowphase->evaluate({.pairs = pairs, .poses = poses, .query = {.kind = QueryKind::distance}},
                        {.status = status, .geometry = geometry}, *workspace);
  std::printf("%s, separation %g m along (%g, %g, %g)\n", to_string(status[0]).data(), geometry[0].separation,
              geometry[0].n_AB_W.x(), geometry[0].n_AB_W.y(), geometry[0].n_AB_W.z());
}
