#pragma once

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

namespace touchstone::native {

/// Answers a distance query, or a manifold query where `points` has slots.
/// @param points max_points slots a pair, or empty.
void compute_geometry(const SolidSet& set, const Kernels& kernels, const NarrowphaseInput& input,
                      std::span<PairStatus> status, std::span<PairGeometry> geometry,
                      std::span<ContactPoint> points);

}  // namespace touchstone::native
