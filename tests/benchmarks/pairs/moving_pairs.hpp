#pragma once

#include <string_view>

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// Overlap of a family's pairs in batches, frame after frame, [ns] a pair: the least of the frames.
struct MovingCost {
  double without_cache, with_cache;
};

/// @param step how far each solid moves a frame, in a direction of its own, to and fro [m].
MovingCost measure_moving_pairs(const BackendRegistry& registry, std::string_view family, double step);

}  // namespace touchstone
