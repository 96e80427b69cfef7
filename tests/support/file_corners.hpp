#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// The corners of hexahedra as files hold them: turned, moved and rounded.

namespace touchstone::file_corners {

using Corners = std::array<Vector3, 8>;

/// Where the block stands and how its coordinates are written.
struct Format {
  std::string name;
  double distance;  ///< of the block from the origin, along each axis [m]
  int decimals;     ///< 0: not decimal
  bool single;      ///< as floats
};

inline std::vector<Format> formats() {
  std::vector<Format> all;
  for (int decimals = 3; decimals <= 12; ++decimals)
    all.push_back({std::to_string(decimals) + " decimals", 2.0, decimals, false});
  all.push_back({"floats", 2.0, 0, true});
  all.push_back({"whole millimetres", 2.0, -3, false});
  for (double distance : {1e3, 1e4}) {
    const std::string far = std::to_string(static_cast<int>(distance)) + " m out, ";
    all.push_back({far + "doubles", distance, 0, false});
    all.push_back({far + "3 decimals", distance, 3, false});
    if (distance < 2e3) all.push_back({far + "floats", distance, 0, true});
  }
  return all;
}

inline double written(double x, const Format& format) {
  if (format.single) return static_cast<float>(x);
  if (format.decimals == -3) return std::round(x * 1000.0) / 1000.0;
  if (format.decimals == 0) return x;
  return std::stod([&] {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", format.decimals, x);
    return std::string(text.data());
  }());
}

/// A block with sides of 0.1 to 10 m, every third tapered and every third sheared, in the order of
/// Hexahedron.
inline Corners block(std::mt19937_64& random, int kind) {
  Vector3 side;
  for (int axis = 0; axis < 3; ++axis) side(axis) = 0.1 * std::pow(100.0, uniform(random, 0.0, 1.0));
  const double taper_x = kind % 3 == 1 ? uniform(random, 0.5, 1.0) : 1.0;
  const double taper_y = kind % 3 == 1 ? uniform(random, 0.5, 1.0) : 1.0;
  const double shear_x = kind % 3 == 2 ? uniform(random, -0.5, 0.5) : 0.0;
  const double shear_y = kind % 3 == 2 ? uniform(random, -0.5, 0.5) : 0.0;
  Corners corners;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 4 ? 0.5 : -0.5, y = i & 2 ? 0.5 : -0.5, z = i & 1 ? 0.5 : -0.5;
    corners[i] = {side.x() * x * (z > 0.0 ? taper_x : 1.0) + shear_x * side.z() * z,
                  side.y() * y * (z > 0.0 ? taper_y : 1.0) + shear_y * side.z() * z, side.z() * z};
  }
  return corners;
}

/// Turned, moved, and as the file has it.
inline Corners in_file(const Corners& corners, const Format& format, std::mt19937_64& random) {
  const Pose X = random_pose(random, Vector3::Constant(format.distance), 1.0);
  Corners out;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = transform(X, corners[i]);
    for (int axis = 0; axis < 3; ++axis) out[i](axis) = written(p(axis), format);
  }
  return out;
}

/// In random order.
inline Corners shuffled(Corners corners, std::mt19937_64& random) {
  for (std::size_t i = 7; i > 0; --i)
    std::swap(corners[i],
              corners[static_cast<std::size_t>(uniform(random, 0.0, 1.0) * static_cast<double>(i + 1))]);
  return corners;
}

}  // namespace touchstone::file_corners
