#pragma once

#include <random>

#include "touchstone/contact_core/geometry/pose.hpp"

// Random cases that are the same on every compiler: what takes several draws takes them in a stated order,
// never two in one argument list. Callers do likewise: braces have an order, parentheses have none.

namespace touchstone {

/// [low, high), from the upper 53 bits of one draw.
inline double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

/// Every coordinate in [low, high); x first.
inline Vector3 random_vector(std::mt19937_64& random, double low, double high) {
  const double x = uniform(random, low, high), y = uniform(random, low, high), z = uniform(random, low, high);
  return {x, y, z};
}

inline Vector3 random_vector(std::mt19937_64& random, double extent) {
  return random_vector(random, -extent, extent);
}

/// Every rotation as likely; w first. (The standard library's own normal distribution.)
inline Matrix3 random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return rotation_from_quaternion(w, x, y, z);
}

/// Within `extent` of the centre along each axis; the rotation first.
inline Pose random_pose(std::mt19937_64& random, const Vector3& centre, double extent) {
  const Matrix3 R = random_rotation(random);
  return {R, centre + random_vector(random, extent)};
}

inline Pose random_pose(std::mt19937_64& random, double extent) {
  return random_pose(random, Vector3::Zero(), extent);
}

}  // namespace touchstone
