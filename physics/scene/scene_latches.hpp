#pragma once

#include <cstddef>
#include <span>

#include "touchstone/physics/scene/dynamic_scene.hpp"

/// @file
/// A dynamic scene's latches by one number: those that hold from the start, then its actions, then its
/// options.

namespace touchstone::physics {

inline constexpr std::size_t kNoLatch = static_cast<std::size_t>(-1);  ///< no number of one

/// The number of the scene's first option.
std::size_t first_latch_option(const DynamicScene& scene);
/// The scene's option for the two objects, else its latch of them, else its action; kNoLatch: it has none.
std::size_t latch_between(const DynamicScene& scene, std::size_t carrier, std::size_t carried);
/// The pairs that are not checked while it holds. @pre a latch of the scene
std::span<const ExemptPair> allowed_by(const DynamicScene& scene, std::size_t latch);

}  // namespace touchstone::physics
