#pragma once

#include <random>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/motion/path.hpp"

namespace touchstone::impact {

/// Two solids, each on an even way: its origin straight, its turn about one axis.
struct Motion {
  Hexahedron a, b;
  RigidPath path_a, path_b;
};

/// A family of random motions.
struct Family {
  std::string_view name;
  Motion (*make)(std::mt19937_64&);
};

std::vector<Family> families();

}  // namespace touchstone::impact
