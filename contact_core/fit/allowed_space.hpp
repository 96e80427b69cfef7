#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// A box with an error of its own, in the part's frame.
struct LimitBox {
  Bounds box;
  double limit;  ///< [m]
};

/// Where a cover may go: within `over` of the solid, in boxes of their own within these boxes' limits. An
/// octree of distances, refined where it is asked: its cells know how far they may be from the solid, so most
/// of a hexahedron is decided by a few of them. For one thread.
class AllowedSpace {
 public:
  AllowedSpace(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes);

  /// What is allowed at a point [m].
  double limit_at(const Vector3& p) const;
  /// Whether the hexahedron keeps to what is allowed, up to cells of a sixteenth of it: a filter, no proof.
  bool allows(const SixPlanes& solid);

 private:
  struct Cell {
    Vector3 centre;
    double half;
    double distance;             ///< signed, of the centre
    double limit;                ///< at the centre
    double least_limit;          ///< of any point of the cell
    std::uint32_t children = 0;  ///< the first of eight; 0: none yet
  };

  Cell make_cell(const Vector3& centre, double half, const Cell* parent) const;
  void divide(std::uint32_t cell);
  struct Query;
  bool is_violated(const Query& query, std::uint32_t cell);

  const MeshDistance& mesh_;
  double over_;
  std::vector<LimitBox> boxes_;
  std::vector<Cell> cells_;
};

}  // namespace touchstone::fit
