#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/parts/prisms.hpp"
#include "touchstone/contact_core/fit/parts/sectors.hpp"
#include "touchstone/contact_core/fit/space/allowed_space.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// The solid to be covered, in pieces: it is cut by a tree of axis-aligned boxes, and about bores by half
/// planes from the axis, so that one hexahedron a sector can hold all of its cells. Prisms are cut by
/// themselves, between their levels and across their axes.
///
/// A cell's points are the corners of its clipped triangles and those of its box's corners that are inside.
/// Their hull holds all of the solid in the box: an extreme point of what is in the box is a corner of one or
/// the other (where shells meet, of a clipped triangle too). So a convex solid that holds the points covers
/// the cell, and one that covers every cell covers the solid.
class Cells {
 public:
  struct Cell {
    Vector3 low, high;        ///< bounds of its points [m]
    std::uint32_t first = 0;  ///< of its points
    std::uint32_t count = 0;
    bool has_surface = false;
    std::uint32_t prism = kNoIndex;  ///< that it is a piece of
    std::uint32_t ring = kNoIndex;   ///< sectors that have a shell of their own, of which it is a piece
    std::uint32_t strip = 0;         ///< of that prism, or the sector
  };
  static constexpr std::size_t kMost = std::size_t{1} << 21;  ///< of some 300 bytes each

  /// @param shift of the tree's low corner, a share of the largest cell: where the cuts are is chance, and
  /// how few hexahedra hold all cells depends on it
  /// @throws InputError: there would be more than `most`
  Cells(const MeshDistance& mesh, const AllowedSpace& allowed, double over,
        std::span<const Sectors> sectors = {}, double shift = 0.0, std::span<const Prism> prisms = {},
        std::size_t most = kMost);

  std::size_t size() const { return cells_.size(); }
  const Cell& cell(std::size_t i) const { return cells_[i]; }
  std::span<const Vector3> points(std::size_t i) const {
    return std::span<const Vector3>(points_).subspan(cells_[i].first, cells_[i].count);
  }
  /// Appends every cell that the solid holds, ascending.
  void held(const SixPlanes& solid, std::vector<std::uint32_t>& out) const;

 private:
  friend class CellBuilder;
  struct Node {
    Vector3 low, high;         ///< bounds of all points below
    std::uint32_t first, end;  ///< cells below
    std::uint32_t right = 0;   ///< child; the left one is next. 0: a leaf
  };
  struct Holder;
  void held(const Holder& holder, std::uint32_t node, unsigned faces) const;
  void index(std::uint32_t first, std::uint32_t end);

  std::vector<Cell> cells_;
  std::vector<Vector3> points_;
  std::vector<Node> nodes_;
};

}  // namespace touchstone::fit
