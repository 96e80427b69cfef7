#pragma once

#include <random>
#include <string_view>
#include <vector>

#include "touchstone/tests/benchmarks/motion/impact_method.hpp"

namespace touchstone::impact {

/// A family of random motions.
struct Family {
  std::string_view name;
  bool has_turns;
  Motion (*make)(std::mt19937_64&);
};

std::vector<Family> families();

}  // namespace touchstone::impact
