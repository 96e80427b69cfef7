#pragma once

#include <span>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Puts pairs in ascending order, by digits where they are many and `scratch` has room for as many, which is
/// quicker. Takes no memory. @param scratch its elements are lost.
void sort_pairs(std::span<SolidPair> pairs, std::vector<SolidPair>& scratch) noexcept;

}  // namespace touchstone
