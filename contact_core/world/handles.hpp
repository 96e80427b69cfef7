#pragma once

#include <compare>
#include <cstdint>

namespace touchstone {

/// Names an object for as long as it lives; never reused for another.
struct ObjectHandle {
  std::uint32_t slot = 0xffffffff;
  std::uint32_t generation = 0;

  friend auto operator<=>(const ObjectHandle&, const ObjectHandle&) = default;
};

/// Names a mechanism for as long as it lives; never reused for another.
struct MechanismHandle {
  std::uint32_t index = 0xffffffff;
  std::uint32_t generation = 0;

  friend auto operator<=>(const MechanismHandle&, const MechanismHandle&) = default;
};

}  // namespace touchstone
