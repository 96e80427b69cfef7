#pragma once

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone {

/// An arm of the Space Station Remote Manipulator System's type (Canadarm2): 7 revolute joints, roll, yaw,
/// pitch, pitch, pitch, yaw, roll, 47 hexahedra, 16.9378 m straight along +x at all values 0.
///
/// Model: Nguyen and Hughes, "Teleoperation: from the space shuttle to the space station", Progress in
/// Astronautics and Aeronautics 161 (1994): joint origins, masses and inertias. Public models of the arm
/// differ by up to 7 % in boom length. Limits +-270 deg, 4 deg/s, 2332 N m each; boom diameter 0.35 m, and
/// what the end effectors measure (radius 0.208, bore 0.100 m): public figures. Assumed here: bores 0.30 m
/// deep (a grapple probe reaches in 0.273 m), joint housings 0.35 m across that stand out by half of that
/// beyond the joints they join, centres of mass in the middle of each link's span, the four joint clusters'
/// inertias as solid boxes.
///
/// Links: base_lee, shoulder_roll, shoulder_yaw, upper_boom, lower_boom, wrist_pitch, wrist_yaw, tip_lee, and
/// tip, a frame without solids in the plane of the free end's mouth. The base's frame is in the plane of its
/// mouth: hold the arm by `base_lee` or by `tip` (Mechanism::with_base).
///
/// Round parts circumscribe their circles (so the solids hold the real part, but for the bores, which are
/// wider than theirs): booms are 12-gons, all else octagons; facet_figures has the errors, 6.2 mm on the
/// booms, 17.1 mm on the end effectors.
///
/// The published inertias of end effectors and booms are stated about the links' frames, but are less than
/// mass times the squared distance to mid-span, which is impossible. They are kept as published; a user who
/// computes dynamics has to choose.
MechanismDescription make_ssrms();

/// make_ssrms() that may stand on either end: `base_tip` is to the base's mouth as `tip` is to the other's, a
/// frame without solids whose x axis comes out of it.
MechanismDescription make_walking_ssrms();

}  // namespace touchstone
