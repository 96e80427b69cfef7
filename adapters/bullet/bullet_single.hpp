#pragma once

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// Narrowphases `bullet_single` and `bullet_single_gjk`, broadphase `bullet_single`: as in bullet.hpp, with
/// the stock single-precision build of Bullet (library touchstone::bullet_single). Poses and vertices are
/// rounded to float where they enter the engine; solids that this flattens or overflows are refused by
/// build(). Never in one program with touchstone::bullet.
///
/// The declared resolution of GJK/EPA is its own tolerance, 1e-3 m. Rare pairs of metre-sized solids
/// (measured: 1 in 2000 near touching, 1 in 12 000 random) are off by several millimetres, once to the wrong
/// side of contact.
void register_bullet_single(BackendRegistry& registry);

}  // namespace touchstone
