#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/contact_core/geometry/disjoint_sets.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"

namespace touchstone {

/// Vertices by place, open addressing; 0 is -0. The first one gives the index, so that no order of a hash
/// shows.
class Places {
 public:
  explicit Places(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), kNoIndex) {}

  std::uint32_t index_of(const Vector3& place, std::vector<Vector3>& kept) {
    std::size_t slot = hash(place) & (slots_.size() - 1);
    while (slots_[slot] != kNoIndex && kept[slots_[slot]] != place) slot = (slot + 1) & (slots_.size() - 1);
    if (slots_[slot] == kNoIndex) {
      slots_[slot] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(place);
    }
    return slots_[slot];
  }

 private:
  static std::size_t hash(const Vector3& place) {
    std::uint64_t h = 0;
    for (int i = 0; i < 3; ++i) {
      h ^= std::bit_cast<std::uint64_t>(place[i] + 0.0);
      h *= 0x9e3779b97f4a7c15ULL;  // 2^64 / golden ratio
      h ^= h >> 32;
    }
    return h;
  }

  std::vector<std::uint32_t> slots_;
};

/// The vertices' shells, by joining the corners of each triangle.
inline DisjointSets join_corners(const TriangleMesh& mesh) {
  DisjointSets out(mesh.vertices.size());
  for (const auto& corners : mesh.triangles)
    for (int i = 1; i < 3; ++i) out.join(corners[0], corners[i]);
  return out;
}

}  // namespace touchstone
