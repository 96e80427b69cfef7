#pragma once

#include "touchstone/physics/engine/engine_registry.hpp"

/// @file
/// Dynamic scenes in ODE (double precision), as two engines: `ode` steps by dWorldQuickStep() (20 sweeps: for
/// many bodies), `ode_direct` by dWorldStep() (a direct method, cubic in what touches: for arms, and few
/// contacts). Each with ODE's own check (`own`), or with ours (`native`, or any narrowphase by its name):
/// every solid then is a geom of adapters/ode_plugin, so that nothing of the process's tables changes. ODE's
/// headers are not needed here.
///
/// How a scene is modelled. Bodies at their centre of mass, boxes as dBox (own) or hexahedron geoms (native).
/// Joints are hinges and sliders with motors (rate drives and brakes: dParamVel, dParamFMax; torques are
/// added), latches are fixed joints; so are joints between bodies, balls besides, closed loops and all.
/// Friction and restitution are the scene's for every pair. Error reduction (0.2), softness (1e-10) and
/// sweeps are ODE's defaults; nothing is put to sleep. Where a scene asks for `push_out`, depth is taken back
/// at about `part_speed`.
///
/// Errors of ODE's method. Steps are semi-implicit Euler: after t a body in free fall is g h t / 2
/// lower than the parabola. Friction is a pyramid along two axes across the normal, not a cone: up to
/// sqrt(2) mu between them. Joints drift and are drawn back. A link's principal moment below 1e-6 of its
/// largest is raised to that: ODE has no slender rods. Impacts are not distinguished from forces, stops
/// within a step are not located.
///
/// Back in time: a snapshot holds bodies' states to the bit, joints, the order in which pairs come, and the
/// row of random numbers that dWorldQuickStep() sweeps by, of which each engine here has its own. Steps after
/// restore() have the same bits; where a latch or a joint between bodies was made again since, to rounding.
///
/// Features: `ode_direct` the usual ones and joints between bodies (torque and rate drives, brakes and stops;
/// the child must move), `ode` all but these, arms and latches: its sweeps do not converge on joints between
/// unequal masses. Hexahedra that are no boxes with `native` alone (ODE's own check of convexes ends in
/// numbers that are none). Stops further than pi from a joint's start are refused. ODE's direct method breaks
/// down (LCP internal error) where pivots tie, as where contacts repeat each other to the bit: corners of a
/// box at rest do with our check, so that ODE gets each of ours 1e-15 to 3e-15 m deeper, by turns. Where it
/// breaks down all the same, the step is taken again with its contacts, not its joints, softer: so that 1e-8,
/// then 1e-6, 1e-4, 1e-2 of the velocity which their impulses give to the lightest body stays, as far as that
/// is softer than usual (EngineStep::unconverged is 1 in such a step); where none helps it fails.

namespace touchstone {

/// Adds engines `ode` and `ode_direct`.
/// @param backends whose narrowphases may stand inside; must outlive the registry's engines
void register_ode_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends);

}  // namespace touchstone
