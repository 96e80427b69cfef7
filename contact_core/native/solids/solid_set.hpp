#pragma once

#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/native/solids/parallelepiped.hpp"
#include "touchstone/contact_core/native/solids/solid_features.hpp"

namespace touchstone::native {

enum class SolidKind : std::uint8_t {
  box,
  parallelepiped,
  general,
};

struct SolidData {
  WorldVertices vertices_S;
  HullRecord hull;
  Hexahedron shape;
  SolidFeatures features;
};

/// The solids as build() keeps them, one vector for each kind of reader: the overlap filters' records stand
/// densely, apart from the rest.
struct SolidSet {
  std::vector<SolidKind> kinds;
  std::vector<std::uint8_t> ordinary;                     ///< by size and place within its frame, see below
  std::vector<BoxRecord> boxes;                           ///< of boxes; infinite where not ordinary
  std::vector<Parallelepiped> parallelepipeds;            ///< of boxes and parallelepipeds; likewise
  std::vector<VertexRecord> vertices;                     ///< not a number where not ordinary
  std::vector<ParallelepipedEdges> parallelepiped_edges;  ///< of parallelepipeds; infinite likewise
  std::vector<SolidData> solids;
};

/// Within these magnitudes sixth powers of lengths, all that is ever formed, neither overflow nor underflow
/// harmfully. Sizes and positions outside are scaled.
inline constexpr double kOrdinaryLow = 0x1p-120;
inline constexpr double kOrdinaryHigh = 0x1p120;

inline Vector3 half_extents(const BoxRecord& box) {
  return {box.half_extents[0], box.half_extents[1], box.half_extents[2]};
}

SolidSet make_solid_set(std::span<const Hexahedron> solids);

/// Replaces the solids from `first` on; appends those beyond the end.
void set_solids(SolidSet& set, std::size_t first, std::span<const Hexahedron> solids);

}  // namespace touchstone::native
