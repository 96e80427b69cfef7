#pragma once

#include "touchstone/physics/engine/engine_registry.hpp"

/// @file
/// Dynamic scenes in MuJoCo, as engine `mujoco`: with its own check (`own`), or with ours through
/// adapters/mujoco_plugin (`native`, or any narrowphase by its name), which stands in the process's table of
/// collision functions during a step and no longer: engines of two threads do not step at one time. MuJoCo's
/// headers are not needed here.
///
/// How a scene is modelled. Bodies at their centre of mass along principal axes, boxes as box geoms, other
/// hexahedra as meshes (whose vertices MuJoCo keeps as floats: off by 1e-7 of the mesh's size). Elliptic
/// cones, Newton's method, MuJoCo's default softness (solref 0.02 s, impratio 1) of contacts and stops.
/// Brakes are `dof_frictionloss`, as hard as MuJoCo lets them be (within two steps, impedance 0.9999): with
/// the default softness a load of four fifths of its limit took one away with 14 mrad/s. Torques are applied
/// to the joint, stops are its range.
///
/// Errors of MuJoCo's method. Contacts and stops are soft: what rests sinks in, what leans on friction
/// creeps. Steps are semi-implicit Euler: after t a body in free fall is g h t / 2 lower than the parabola. A
/// link's principal moment below 1e-6 of its largest is raised to that. Impacts are not distinguished from
/// forces, stops within a step are not located.
///
/// Joints between bodies are equality constraints `connect`, one of a ball, two of a hinge, three of a fixed
/// one, as hard as brakes; a hinge's torque acts both ways.
/// Loops may be closed, bases free. Refused by name: sliders, stops, motors, losses of such joints.
///
/// Back in time: a snapshot is all of mjData, and what follows restore() has the same bits. Bodies that are
/// out of the world stay in MuJoCo's model: they meet nothing, and are put back after each step.
///
/// Features: hulls, arms with stops, torques and brakes, joints put at values, joints between bodies, bodies
/// that come and go. No restitution (MuJoCo has no coefficient), no kinematic bodies (its mocap bodies have
/// no velocity in contacts), no rate drives with limits, no latches, one friction. What starts in each other
/// is refused where the scene asks for `push_out`: soft contacts throw it apart. MuJoCo 2.2 counts the bytes
/// of its tables in an int: scenes beyond 2 GB, with room for five contacts a body at some 700 free bodies,
/// are refused; from 2.3 on they come from an arena, which has room for twelve. Beyond 600 degrees of freedom
/// the solver is MuJoCo's conjugate gradients: Newton's method of 2.2 factors a dense matrix of them.

namespace touchstone {

/// Adds engine `mujoco`.
/// @param backends whose narrowphases may stand inside; must outlive the registry's engines
void register_mujoco_dynamics(physics::EngineRegistry& registry, const BackendRegistry& backends);

}  // namespace touchstone
