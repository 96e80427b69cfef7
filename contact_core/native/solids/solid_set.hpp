#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <type_traits>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/record_list.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/contact_core/native/solids/parallelepiped.hpp"
#include "touchstone/contact_core/native/solids/solid_features.hpp"

namespace touchstone::native {

enum class SolidKind : std::uint8_t {
  box,
  parallelepiped,
  general,
};

/// The faces and edges of a solid's hull, for the kernels and for the rest. All boxes have the same.
struct SolidHull {
  PlainHull plain;
  HullRecord record;
  SolidFeatures features;
  WorldVertices vertices_S;  ///< only of a solid that is not ordinary
};

struct SolidData {
  double size;             ///< largest distance between two vertices [m]
  double middle;           ///< largest |coordinate| of its bounding box's centre [m]
  const SolidHull* hull;   ///< never null; SolidSet::hulls keeps it
  const PlainHull* plain;  ///< of that, null where it is none
};

/// The solids as build() keeps them, one list for each kind of reader: the overlap filters' records stand
/// densely, apart from the rest. While all solids are boxes, nobody reads what is kept of parallelepipeds:
/// those two lists then stay empty.
struct SolidSet {
  GrowingList<SolidKind> kinds;
  GrowingList<std::uint8_t> ordinary;           ///< by size and place within its frame, see below
  GrowingList<BoxRecord> boxes;                 ///< of boxes; `reach` is infinite where not ordinary
  GrowingList<Parallelepiped> parallelepipeds;  ///< of boxes and parallelepipeds; likewise, by centre
  GrowingList<WorldVertices> vertices;          ///< in solids' frames; not a number where not ordinary
  GrowingList<ParallelepipedEdges> parallelepiped_edges;  ///< of parallelepipeds; infinite likewise
  GrowingList<SolidData> solids;
  RecordList<std::shared_ptr<const SolidHull>, 32> hulls;
  GrowingList<double> radii;  ///< empty while no solid is rounded [m]
};

/// Within these magnitudes sixth powers of lengths, all that is ever formed, neither overflow nor underflow
/// harmfully. Sizes and positions outside are scaled.
inline constexpr double kOrdinaryLow = 0x1p-120;
inline constexpr double kOrdinaryHigh = 0x1p120;

inline Vector3 half_extents(const BoxRecord& box) {
  return {box.half_extents[0], box.half_extents[1], box.half_extents[2]};
}

/// The kind whose kernels fit both solids.
inline SolidKind kind_of(const SolidSet& set, const SolidPair& pair) {
  return std::max(set.kinds[pair.a], set.kinds[pair.b]);
}

/// As the kernels read them: R by columns, then p.
inline const PoseRecord* records_of(std::span<const Pose> poses) {
  static_assert(sizeof(Pose) == sizeof(PoseRecord) && std::is_standard_layout_v<Pose>);
  static_assert(!Matrix3::IsRowMajor);
  return reinterpret_cast<const PoseRecord*>(poses.data());
}

/// The solid's vertices in its own frame, whatever its magnitudes.
inline const WorldVertices& local_vertices(const SolidSet& set, std::size_t solid) {
  return set.ordinary[solid] ? set.vertices[solid] : set.solids[solid].hull->vertices_S;
}

/// Vertices as the kernels read them.
inline const VertexRecord& as_record(const WorldVertices& v) {
  return reinterpret_cast<const VertexRecord&>(v);
}
inline VertexRecord& as_record(WorldVertices& v) { return reinterpret_cast<VertexRecord&>(v); }

/// SolidSet::vertices likewise.
const VertexRecord* vertex_records(const SolidSet& set);

SolidSet make_solid_set(std::span<const Hexahedron> solids);

/// Makes room for this many solids, and more (reserve_more.hpp), that come later.
void take_room(SolidSet& set, std::size_t solids);

inline double radius_of(const SolidSet& set, std::size_t solid) {
  return set.radii.empty() ? 0.0 : set.radii[solid];
}

/// Replaces the solids from `first` on; appends those beyond the end.
/// @pre first is at most the number of solids.
void set_solids(SolidSet& set, std::size_t first, SolidSet solids);
/// The same of solids that have no set yet.
void set_solids(SolidSet& set, std::size_t first, std::span<const Hexahedron> solids);

/// A set of this many places, for solids without a radius that come and go while others are read: putting
/// some in writes their own records alone, and moves and resizes none of the lists.
SolidSet make_places(std::size_t count);
/// Gives solids all that such places have.
void make_placeable(SolidSet& solids);
/// Throws nothing. @pre placeable, or a set of places; they fit in.
void put_in_places(SolidSet& set, std::size_t first, const SolidSet& solids);

}  // namespace touchstone::native
