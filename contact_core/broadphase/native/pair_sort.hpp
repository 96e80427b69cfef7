#pragma once

#include <span>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Puts pairs in ascending order, by digits where they are many. @param scratch takes memory only where it
/// has no room for as many.
void sort_pairs(std::span<SolidPair> pairs, std::vector<SolidPair>& scratch) noexcept;

}  // namespace touchstone
