#pragma once

#include <compare>
#include <cstdint>

#include "touchstone/contact_core/geometry/no_index.hpp"

namespace touchstone {

/// Names an object for as long as it lives; never reused for another.
struct ObjectHandle {
  std::uint32_t slot = kNoIndex;
  std::uint32_t generation = 0;

  friend auto operator<=>(const ObjectHandle&, const ObjectHandle&) = default;
};

/// Names a mechanism for as long as it lives; never reused for another.
struct MechanismHandle {
  std::uint32_t index = kNoIndex;
  std::uint32_t generation = 0;

  friend auto operator<=>(const MechanismHandle&, const MechanismHandle&) = default;
};

}  // namespace touchstone
