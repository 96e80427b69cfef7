#pragma once

#include "touchstone/physics/engine/engine_registry.hpp"

/// @file
/// Dynamic scenes in Bullet (double precision), as engine `bullet`: with its own check (`own`), or with ours
/// inside through adapters/bullet_plugin (`native`, or any narrowphase by its name). Bullet's headers are not
/// needed here.
///
/// How a scene is modelled. Bodies at their centre of mass, along principal axes; boxes are btBoxShapes,
/// other hexahedra btConvexHullShapes without margin, several solids a btCompoundShape. Friction and
/// restitution are the scene's for every pair (geometric mean, the larger), bounce speed too. Solver,
/// iterations (10), error reduction and split impulses are Bullet's defaults; nothing is put to sleep. With
/// ten iterations our check has the middle of a patch first (BulletPlugin::Options::middle_first). Where a
/// scene asks for `push_out`, the solver gets no depth beyond what it takes back at `part_speed`.
///
/// Arms are btMultiBodies (Featherstone's articulated bodies: no joint yields, whatever the masses). Torques
/// are applied to the joint, brakes and rates are btMultiBodyJointMotors with an impulse of at most limit
/// times step, stops btMultiBodyJointLimitConstraints; damping, which Bullet has on by default, is off. A
/// latched body becomes a fixed link of its carrier's btMultiBody, which is made anew when a latch closes or
/// opens (that step allocates); momentum stays. A scene with an arm or a latch is a btMultiBodyDynamicsWorld,
/// others a btDiscreteDynamicsWorld. Motors, brakes and stops get ten sweeps in each iteration.
///
/// Errors of Bullet's method. Steps are semi-implicit Euler: after t a body in free fall is
/// g h t / 2 lower than the parabola. A kinematic body already stands at its pose of the step's end when the
/// step's contacts are found. A stop acts once it is passed, by up to rate times step. Joints' drives and
/// contacts are swept, not solved: of an arm of seven joints with 100 t at its end a braked joint crept at
/// 3e-5 rad/s. A link's principal moment below 1e-6 of its largest is raised to that. Impacts are not
/// distinguished from forces, stops within a step are not located.
///
/// Joints between rigid bodies are Bullet's constraints (fixed, hinge, slider, point to point), swept with
/// the contacts, so that they yield a little; what their motors give is not reported (NaN).
///
/// Snapshots hold the poses and velocities of bodies, the values and rates of joints, latches and joints
/// between bodies. restore() puts the world in anew in that state: Bullet's cached manifolds, with the
/// impulses that its contacts start from, are dropped, so that steps after it are the same after every
/// restore(), but not those of the run that went on.
///
/// Features: the usual ones, joints put at values, joints between bodies, bodies that come and go. Refused by
/// name: friction beyond 10 (Bullet cuts it there), latches on kinematic bodies, joints between bodies on a
/// link, beside latches, or whose child is the ground, and latches whose carried body is a link (they would
/// close a loop).

namespace touchstone {

/// Adds engine `bullet`.
/// @param backends whose narrowphases may stand inside; must outlive the registry's engines
void register_bullet_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends);

}  // namespace touchstone
