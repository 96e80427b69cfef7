#pragma once

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// `brute_force`: every pair of solids of different objects whose world spheres touch, O(n^2): the oracle.
/// `native`: the paper's sphere trees per object under a bounding-box tree over the objects.
void register_broadphases(BackendRegistry& registry);

/// The broadphases of those names, to be built.
std::unique_ptr<Broadphase> make_brute_force_broadphase();
/// @copydoc make_brute_force_broadphase
std::unique_ptr<Broadphase> make_native_broadphase();

}  // namespace touchstone
