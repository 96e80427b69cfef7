#include "touchstone/contact_core/broadphase/register_broadphases.hpp"

namespace touchstone {

void register_broadphases(BackendRegistry& registry) {
  registry.add(BackendRegistry::BroadphaseEntry{"brute_force",
                                                "every pair of world bounding spheres: the oracle",
                                                [] { return make_brute_force_broadphase(); }});
  registry.add(BackendRegistry::BroadphaseEntry{
      "native", "sphere trees per object under a bounding-box tree across objects",
      [] { return make_native_broadphase(); }});
}

}  // namespace touchstone
