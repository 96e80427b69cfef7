#include "touchstone/contact_core/scene/motion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

// A normalised axis is off unit length by a few eps; 1e-9 separates that from one never normalised.
constexpr double kUnitTolerance = 1e-9;

[[noreturn]] void reject(std::string_view name, std::size_t index, const char* what,
                         const std::string& reason) {
  throw InputError(std::string(name) + ": " + what + " " + std::to_string(index) + ": " + reason);
}

void validate_segment(const MotionSegment& segment, double earliest, std::string_view name,
                      std::size_t index) {
  const auto fail = [&](const std::string& reason) { reject(name, index, "motion segment", reason); };
  if (!std::isfinite(segment.start) || segment.start < 0.0) fail("the start is not a time >= 0");
  if (!std::isfinite(segment.duration) || !(segment.duration > 0.0)) fail("the duration is not a time > 0");
  if (!is_finite(segment.velocity_W)) fail("the velocity is not finite");
  if (!is_finite(segment.pivot_W)) fail("the pivot is not finite");
  if (!std::isfinite(segment.rate)) fail("the rate is not finite");
  if (!is_finite(segment.axis_W) || std::abs(norm(segment.axis_W) - 1.0) > kUnitTolerance)
    fail("the axis is not a unit vector");
  if (segment.start < earliest) fail("starts before the one before it ends");
}

Pose after(const MotionSegment& segment, const Pose& X_WO, double elapsed) {
  Pose X = X_WO;
  if (segment.rate != 0.0) {
    const Matrix3 turn = rotation_about(segment.axis_W, segment.rate * elapsed);
    X.R = product(turn, X_WO.R);
    X.p = segment.pivot_W + rotate(turn, X_WO.p - segment.pivot_W);
  }
  X.p += segment.velocity_W * elapsed;
  return X;
}

Pose along_keys(const std::vector<KeyedPose>& keys, const Pose& X_WO_initial, double time) {
  KeyedPose previous{0.0, X_WO_initial};
  for (const KeyedPose& key : keys) {
    if (time < key.time)
      return interpolate(previous.X_WO, key.X_WO, (time - previous.time) / (key.time - previous.time));
    previous = key;
  }
  return previous.X_WO;
}

}  // namespace

void validate_motion(const Motion& motion, std::string_view name) {
  if (!motion.segments.empty() && !motion.keys.empty())
    throw InputError(std::string(name) + ": a motion has segments or keys, not both");
  double earliest = 0.0;
  for (std::size_t i = 0; i < motion.segments.size(); ++i) {
    validate_segment(motion.segments[i], earliest, name, i);
    earliest = motion.segments[i].start + motion.segments[i].duration;
  }
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    const KeyedPose& key = motion.keys[i];
    if (!std::isfinite(key.time) || key.time < 0.0)
      reject(name, i, "motion key", "the time is not a time >= 0");
    if (i > 0 && key.time <= motion.keys[i - 1].time)
      reject(name, i, "motion key", "not later than the one before it");
    validate_pose(key.X_WO, std::string(name) + ": motion key " + std::to_string(i));
  }
}

Pose pose_at(const Motion& motion, const Pose& X_WO_initial, double time) noexcept {
  if (!motion.keys.empty()) return along_keys(motion.keys, X_WO_initial, std::max(time, 0.0));
  Pose X_WO = X_WO_initial;
  for (const MotionSegment& segment : motion.segments) {
    if (time <= segment.start) break;
    X_WO = after(segment, X_WO, std::min(time - segment.start, segment.duration));
  }
  return X_WO;
}

Pose interpolate(const Pose& from, const Pose& to, double s) noexcept {
  if (s <= 0.0) return from;
  if (s >= 1.0) return to;
  Pose X;
  X.R = rotation_matrix(slerp(quaternion_of(from.R), quaternion_of(to.R), s));
  X.p = (1.0 - s) * from.p + s * to.p;
  return X;
}

}  // namespace touchstone
