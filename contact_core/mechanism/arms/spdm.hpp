#pragma once

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone {

/// A manipulator of the type of the SPDM (Dextre): a body that rolls on its mount, on it two arms of seven
/// revolute joints (shoulder roll, yaw, pitch, elbow pitch, wrist pitch, yaw, roll), each with an OTCM whose
/// two jaws are prismatic joints: 19 values, `body_roll` first, then arm 1 and arm 2, each with its jaws
/// last.
///
/// Joint origins of an arm are six read in a public source; wrist pitch and yaw share one. OTCM: 0.919 m
/// long, radius 0.154 to 0.228 m, public figures. In all 1 662 kg: a public figure.
///
/// Assumed: all axes (roll x, yaw z, pitch y of frames that are parallel at 0); arm 2 as arm 1 mirrored in
/// the body's x-y plane; the body as a T; links as square bars from joint to joint; where an OTCM is thick;
/// jaws of 60 x 20 x 40 mm, 60 mm apart open, 5 mm/s each, 500 N; limits +-170 deg, 4 deg/s, 500 N m; how the
/// mass is shared out. An OTCM's torquer, advancer, umbilical, cameras and lights are left out.
///
/// Links: mount (the base), body, and of arm n (1, 2) shoulder_roll_n, shoulder_yaw_n, upper_arm_n,
/// forearm_n, wrist_pitch_n (a cube), wrist_yaw_n, otcm_n, left_jaw_n, right_jaw_n and tip_n, a frame
/// without solids between the jaws, its x axis out of the tool. A jaw's value is how far it has closed, 0 to
/// 29 mm.
MechanismDescription make_spdm();

/// Arm 1 alone on a fixed shoulder: the base is `post`; 9 values.
MechanismDescription make_spdm_arm();

}  // namespace touchstone
