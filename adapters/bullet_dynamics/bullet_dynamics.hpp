#pragma once

#include "touchstone/physics/engine/engine_registry.hpp"

/// @file
/// Dynamic scenes in Bullet (double precision), as engine `bullet`: with its own check (`own`), or with ours
/// inside through adapters/bullet_plugin (`native`). Bullet's headers are not needed here.
///
/// What a scene becomes. Bodies at their centre of mass, along principal axes; boxes are btBoxShapes, other
/// hexahedra btConvexHullShapes without margin, several solids a btCompoundShape. Friction and restitution
/// are the scene's for every pair (geometric mean, the larger), bounce speed too. Solver, iterations (10),
/// error reduction and split impulses are Bullet's defaults; nothing is put to sleep. With ten iterations our
/// check has the middle of a patch first (BulletPlugin::Options::middle_first).
///
/// What Bullet's method does to figures. Steps are semi-implicit Euler: after t a body in free fall is
/// g h t / 2 lower than the parabola. Where a kinematic body is told to be at a step's end it stands when the
/// step's contacts are found. Impacts are not told from forces, stops within a step are not located.
///
/// Friction beyond 10 is refused (Bullet cuts it there). Features: hulls, kinematic bodies, friction,
/// restitution.

namespace touchstone {

/// Adds engine `bullet`.
void register_bullet_dynamics(physics::EngineRegistry& registry);

}  // namespace touchstone
