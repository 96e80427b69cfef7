#pragma once

#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone {

/// Constant velocity over a stretch of time: the object turns about an axis through a pivot that itself moves
/// with `velocity_W`. From the pose X at `start`: X(t) = translate(velocity_W dt) * turn(axis_W, rate dt,
/// about pivot_W) * X.
struct MotionSegment {
  double start = 0.0;                    ///< [s], >= 0
  double duration = 0.0;                 ///< [s], > 0
  Vector3 velocity_W = Vector3::Zero();  ///< [m/s]
  Vector3 axis_W = Vector3::UnitZ();     ///< unit (normalised by whoever fills it in)
  double rate = 0.0;                     ///< right-handed about axis_W [rad/s]
  Vector3 pivot_W = Vector3::Zero();     ///< where the pivot is at `start` [m]
};

/// A commanded pose at a time.
struct KeyedPose {
  double time = 0.0;  ///< [s], >= 0
  Pose X_WO;
};

/// The prescribed path of one object: segments or keys, not both; neither means at rest.
struct Motion {
  /// In order of time, not overlapping; the pose is held between and after them.
  std::vector<MotionSegment> segments;
  /// In order of time; positions are interpolated linearly, rotations by slerp. Before the first key the path
  /// starts from the initial pose at time 0; after the last it is held.
  std::vector<KeyedPose> keys;

  bool at_rest() const { return segments.empty() && keys.empty(); }
};

/// @throws InputError naming `name` and the segment or key: times out of order or overlapping, figures that
/// are not finite, an axis that is not unit, both segments and keys.
void validate_motion(const Motion& motion, std::string_view name);

/// The commanded pose at `time` [s]; the initial pose for time <= 0. The same bits everywhere. No allocation.
/// @pre motion is valid.
Pose pose_at(const Motion& motion, const Pose& X_WO_initial, double time) noexcept;

/// Lerp of the positions, slerp along the shorter arc of the rotations; s in [0, 1], the ends are returned
/// exactly.
Pose interpolate(const Pose& from, const Pose& to, double s) noexcept;

}  // namespace touchstone
