#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// A box with an error of its own, which may be turned in the part's frame.
struct LimitBox {
  Bounds box;
  double limit;                        ///< [m]
  Matrix3 axes = Matrix3::Identity();  ///< columns: the box's, in the part's frame

  /// Whether a cube, half of whose width is `half`, may touch it: for sure where it does.
  bool touches(const Vector3& centre, double half) const;
  /// The same of the hull of these points.
  bool touches(std::span<const Vector3> corners) const;
};

/// The least of `over` and of the limits of the boxes that the hull of these points may touch [m].
double least_limit(double over, std::span<const LimitBox> boxes, std::span<const Vector3> corners);

/// Where a cover may go: within `over` of the solid, in boxes of their own within these boxes' limits.
///
/// An octree of distances, refined where it is asked. Its leaves, a sixth of the limit wide or less, give
/// points at which what is allowed ends; every cell knows a box about those below it, from the start where a
/// flat wall or one triangle says it. So "how far may this face go" is one search for the lowest such point
/// before the face, and of a flat wall it looks at one place, not at all of it. A filter, no
/// proof: a corner or an edge can reach between points, by half their distance. For one thread.
class AllowedSpace {
 public:
  static constexpr std::size_t kMostCells = std::size_t{1} << 24;  ///< of some 150 bytes each

  /// @param most_cells queries that would take more throw an InputError
  AllowedSpace(const MeshDistance& mesh, double over, std::span<const LimitBox> boxes,
               std::size_t most_cells = kMostCells);

  /// The excess that is allowed at a point [m].
  double limit_at(const Vector3& p) const;
  /// The least that is allowed at any point of a cube, half of whose width is `half` [m].
  double least_limit(const Vector3& centre, double half) const;
  /// The least that is allowed at any point of the hull of these corners, or close beside it [m].
  double least_limit(std::span<const Vector3> corners) const;
  /// Whether the hexahedron holds a point that forbid() named.
  bool holds_forbidden(const SixPlanes& solid) const;
  /// Whether a point keeps to it.
  bool allows(const Vector3& p) const;
  /// Whether the hexahedron keeps to what is allowed.
  bool allows(const SixPlanes& solid);
  /// The same of a lattice of its points, which a void between may go through: a proof looks at the others.
  bool allows_samples(const SixPlanes& solid) const;
  /// Cells looked at so far: what queries cost, the same on every machine.
  std::uint64_t visits() const { return visits_; }
  /// From now on this point is not allowed.
  void forbid(const Vector3& p) { forbidden_.push_back(p); }
  /// How far the face may move outwards, the others staying where they are: at most `far` [m].
  double room(const SixPlanes& solid, int face, double far);
  /// How steeply the face may rise from an edge of its own at `edge`, along its plane's direction `across`,
  /// unit, away from the edge: at most `steepest`, a tangent.
  double slope(const SixPlanes& solid, int face, const Vector3& edge, const Vector3& across, double steepest);

 private:
  enum class Kind : std::uint8_t {
    open,   ///< has children, or may get them
    clear,  ///< all of it is allowed
    point,  ///< a leaf: `low` is where what is allowed ends
    block,  ///< nothing between `low` and `high` is allowed, and all the rest of it
  };
  /// What a search looks at: one walks over millions.
  struct Cell {
    Vector3 low, high;  ///< box about what is not allowed in it, as far as known
    /// Space that is not allowed is at least `wall_at` along `wall`, too; zero: nothing is known.
    Vector3 wall = Vector3::Zero();
    double wall_at = 0.0;
    double least_limit;          ///< of any point of the cell
    std::uint32_t children = 0;  ///< the first of eight; 0: none yet
    Kind kind = Kind::open;
  };
  /// Where a cell is, for its children.
  struct Place {
    Vector3 centre;
    double half;
    double distance = 0.0;       ///< signed, of the centre
    std::uint32_t triangle = 0;  ///< the nearest to the centre
    int winding = 0;             ///< number of the centre
  };
  struct NewCell : Cell, Place {};

  NewCell make_cell(const Vector3& centre, double half, const Place* parent) const;
  int winding_at(const Vector3& p, const Place& near) const;
  std::uint32_t cell_at(const Vector3& p) const;
  void keep(const NewCell& cell);
  void classify(NewCell& cell) const;
  bool is_cut_by_boxes(NewCell& cell) const;
  bool is_near_one_triangle(const NewCell& cell, const Vector3& away) const;
  void draw_in(NewCell& cell) const;
  bool find_wall(NewCell& cell) const;
  void divide(std::uint32_t cell);
  struct Query;
  static double earliest(const Query& query, const Cell& cell);
  void search(Query& query);
  /// @param faces bits of those that may have some of the cell outside. @return whether the cell's box or
  /// kind has changed
  bool search(Query& query, std::uint32_t cell, unsigned faces);
  bool search_children(Query& query, std::uint32_t cell, unsigned faces, bool is_new);
  void search_block(Query& query, const Bounds& block, double limit, unsigned faces) const;

  const MeshDistance& mesh_;
  double over_;
  std::vector<LimitBox> boxes_;
  std::size_t most_cells_;
  std::vector<Cell> cells_;
  std::vector<Place> places_;  ///< of the cells
  std::vector<Vector3> forbidden_;
  std::uint64_t visits_ = 0;
};

}  // namespace touchstone::fit
