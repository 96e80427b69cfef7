#pragma once

#include "contact_core/registry.hpp"
#include "examples/measures/oracle.hpp"

// Unit cubes side by side along x: everything about a pair follows from its gap.

namespace touchstone::comparison::testing {

/// `gaps.size()` pairs of unit cubes with these gaps along x [m].
PairSet cubes(const std::vector<double>& gaps);

/// Knows cubes() and nothing else.
class CubeOracle final : public Oracle {
 public:
  PairTruth truth(const WorldVertices& a, const WorldVertices& b) const override;
  double surface_distance(const WorldVertices& solid, const Vector3& p) const override;
  double patch_area(const WorldVertices& a, const WorldVertices& b, const Vector3& n) const override;
};

/// right, missing_contacts, seeing_phantoms, off_by_1e-3, not_a_number, unsupported, failing, undecided: each
/// wrong in the way it is named. right allocates nothing; every one is told apart by its name.
void register_fakes(BackendRegistry& registry);

}  // namespace touchstone::comparison::testing
