#pragma once

#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/native/solids/solid_features.hpp"

namespace touchstone::native {

/// Two hulls about a common origin, with the features that they come from.
struct PosedPair {
  HullPair hulls;
  const SolidFeatures* a;
  const SolidFeatures* b;
  Matrix3 R_WA;
  Matrix3 R_WB;
  Vector3 start;  ///< from A's middle to B's: the first direction of searches
};

}  // namespace touchstone::native
