#pragma once

#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone {

/// random_poses.hpp's draws from a generator of its own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) { return touchstone::uniform(engine_, low, high); }
  /// Every coordinate in [-size, size).
  Vector3 vector(double size) { return random_vector(engine_, size); }
  /// 0 to count - 1.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(engine_() % count); }
  bool one_in(std::uint32_t count) { return below(count) == 0; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace touchstone
