#pragma once

#include <cstdint>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace touchstone {

// GCC's and Clang's vector types: one register of four lanes, on any instruction set.
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));

/// Four floats from anywhere.
inline Floats load_floats(const float* from) {
  Floats lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

inline Floats all_lanes(float v) { return Floats{v, v, v, v}; }

/// Bit k: lane k is set (all ones, as comparisons leave it).
inline std::uint32_t lane_mask(Ints hit) {
#ifdef __SSE2__
  return static_cast<std::uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(hit)));
#else
  return (hit[0] & 1u) | (hit[1] & 2u) | (hit[2] & 4u) | (hit[3] & 8u);
#endif
}

}  // namespace touchstone
