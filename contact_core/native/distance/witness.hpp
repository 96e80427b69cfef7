#pragma once

#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"

namespace touchstone::native {

/// Witness points off by more than this many u * extent make penetration() look at near ties.
inline constexpr double kWitness = 32;

/// The point of W (B minus A) with the simplex's weights.
Vector3 combination(const Simplex& simplex);

/// A witness point on A.
struct Witness {
  Vector3 p_A;
  double error;  ///< length of the two points' difference across n
};

/// A witness point on A for a known normal: B is moved along n to a gap of half the extent, where the closest
/// points are well defined, also for pairs that touch or overlap.
Witness witness_along(const PosedPair& pair, double separation, const Vector3& n);

}  // namespace touchstone::native
