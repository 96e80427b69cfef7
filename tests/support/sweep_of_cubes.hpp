#pragma once

#include <stdexcept>

#include "touchstone/contact_core/motion/sweep.hpp"

namespace touchstone::test {

inline const SweepEntry& sweep_named(const std::vector<SweepEntry>& sweeps, std::string_view name) {
  for (const SweepEntry& entry : sweeps)
    if (entry.name == name) return entry;
  throw std::out_of_range("no sweep " + std::string(name));
}

/// A unit cube goes from x = -3 to 3 past another at the origin, `aside` along y: up to 1 they meet at s =
/// 1/3.
inline std::optional<double> sweep_cubes(const SweepEntry& entry, const Hexahedron& cube, double aside) {
  const auto sweep = entry.make();
  const RigidPath path = RigidPath::by({Matrix3::Identity(), {-3, aside, 0}}, {6, 0, 0}, Vector3::Zero());
  const RigidPath rest{Pose{}};
  sweep->set(cube, path, cube, rest);
  return sweep->impact();
}

}  // namespace touchstone::test
