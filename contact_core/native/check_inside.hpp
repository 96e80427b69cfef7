#pragma once

#include <memory>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::native {
class SolidStore;
}

namespace touchstone {

/// A narrowphase as the plug-ins (adapters/bullet_plugin, ode_plugin, mujoco_plugin) take one inside an
/// engine, in place of `native`: solids come and go, pairs are asked one at a time. Several plug-ins may
/// share one.
using CheckInside = native::SolidStore;

/// Pairs that the narrowphase calls `undecided` count as touching, `failed` and `unsupported` ones have no
/// contacts and are counted as refused.
/// @throws InputError: none given, or one without manifolds (Capabilities::manifold).
std::shared_ptr<CheckInside> make_check_inside(std::unique_ptr<Narrowphase> narrowphase);

}  // namespace touchstone
