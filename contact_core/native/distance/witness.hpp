#pragma once

#include "touchstone/contact_core/native/distance/distance.hpp"
#include "touchstone/contact_core/native/overlap/gjk.hpp"

namespace touchstone::native {

/// Witness points off by more than this many u * extent make penetration() look at near ties.
inline constexpr double kWitness = 32;

/// The point of W (B minus A) that the simplex's weights stand for.
Vector3 combination(const Simplex& simplex);

/// A witness point on A.
struct Witness {
  Vector3 p_A;
  double error;  ///< how far the two points' difference is from lying straight along n
};

/// One point of A whose partner lies straight across along n: B is moved to a comfortable gap along n, where
/// the closest points are well defined, also for pairs that touch or overlap.
Witness witness_along(const PosedPair& pair, double separation, const Vector3& n);

}  // namespace touchstone::native
