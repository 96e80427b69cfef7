#pragma once

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Nothing but a separation [m], NaN where that is not known either: no normal, no witness points, no
/// manifold.
inline PairGeometry no_geometry(double separation = kNaN) {
  const Vector3 unknown = Vector3::Constant(kNaN);
  return {separation, unknown, unknown, unknown, 0};
}

/// Whether the pair can be answered at all: with a pose that holds an infinite number or NaN it is `failed`.
inline bool has_finite_poses(const SolidPair& pair, std::span<const Pose> poses) {
  return is_finite(poses[pair.a]) && is_finite(poses[pair.b]);
}

}  // namespace touchstone
