#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone::station {

/// The hand controllers' deflections: axes from -1 to 1 of the rates in force.
struct HandInput {
  Vector3 translation = Vector3::Zero();
  Vector3 rotation = Vector3::Zero();
  double joint = 0.0;  ///< of the chosen joint, in joint mode
  double grip = 0.0;   ///< of the flown tip's jaws, above 0: closing

  friend bool operator==(const HandInput& a, const HandInput& b) {
    return a.translation == b.translation && a.rotation == b.rotation && a.joint == b.joint &&
           a.grip == b.grip;
  }
};

/// Whose axes the hands' rates are along.
enum class CommandFrame : std::uint8_t { end_effector, base, camera };

/// Something that an operator or an instructor sets, in force from the next frame on.
struct Control {
  enum class Kind : std::uint8_t {
    frame_of_command,  ///< index: CommandFrame; attitude: the camera's
    vernier,           ///< on
    brakes,            ///< on
    joint_mode,        ///< on; index: the joint, while on
    latch,             ///< index: object, or kAny
    release,
    reset,
    scene,        ///< index
    select,       ///< index: object; on
    methods,      ///< index: a bit a method; resets
    policy,       ///< index: ContactPolicy, of `ours`, or kPush
    joint_brake,  ///< a fault. index: joint; on
    late_report,  ///< a fault. value: the report's delay of Figure 1 [s]; resets
    dynamics,     ///< on; resets
    torque_loss,  ///< a fault, with dynamics. index: joint; value: the share of its limit that is left
    tip,          ///< index: of StationScene::tips, which the hand flies from now on
  } kind = Kind::reset;
  bool on = false;
  std::uint32_t index = 0;
  double value = 0.0;
  std::array<double, 4> attitude = {0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w, of unit length

  static constexpr std::uint32_t kAny = 0xffffffff;
};

/// The policy that a world without dynamics has no answer to.
inline constexpr std::uint32_t kPush = 100;

/// Where an input came from, and when.
struct InputStamp {
  std::uint32_t client = 0;  ///< 0: no browser
  std::uint32_t number = 0;  ///< the client's own
  double browser_us = 0.0;   ///< when the hand moved, on the browser's clock; NaN: not given
  double received_us = 0.0;  ///< on the station's
};

}  // namespace touchstone::station
