#pragma once

#include <random>

#include "contact_core/geometry/pose.hpp"

namespace touchstone {

inline Matrix3 random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return rotation_from_quaternion(normal(random), normal(random), normal(random), normal(random));
}

inline Vector3 random_vector(std::mt19937_64& random, double extent) {
  std::uniform_real_distribution<double> uniform(-extent, extent);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

inline Pose random_pose(std::mt19937_64& random, double extent) {
  const Matrix3 R = random_rotation(random);
  return {R, random_vector(random, extent)};
}

}  // namespace touchstone
