#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// A closed shell, or a slice of one, that is a right prism on a convex polygon (a pin, a rod, a bar or a
/// plate), or a tapered one: a cone or a pyramid, with its tip or without, which may lean.
///
/// Its distance is a convex function, so a hexahedron keeps to a limit where its eight corners do: no place
/// between them is looked at. It is covered by slabs across its section, each between two of the section's
/// levels; so a round one of m facets within the limit takes m / 2 - 1. Of a tapered one levels and sides go
/// through its tip.
struct Prism {
  using Point = std::array<double, 2>;
  /// Of a slab's normals: at the flat end of a round section its sides lean by little.
  static constexpr double kLeastDeterminant = 0.1;

  Vector3 axis, up, side;       ///< unit; levels are along `up`, `side` is across both: up x side = axis
  double low, high;             ///< along the axis [m]
  std::vector<Point> section;   ///< at `low`: (up, side), counter-clockwise seen along -axis [m]
  double narrows = 0.0;         ///< by this share of the section from `low` to `high`; 0: not; 1: to its tip
  Point leans = {0.0, 0.0};     ///< section point q of `low` is at (1 - narrows) q + leans at `high` [m]
  std::vector<double> borders;  ///< of the strips between levels, ascending; not the outer ones
  Bounds box;
  double over;                                ///< the least that is asked of a point of it [m]
  double room;                                ///< its surface is within this of what stands here [m]
  double thickness = 0.0;                     ///< of its section and along the axis, the least [m]
  std::vector<std::uint32_t> triangles;       ///< of its shell
  std::vector<Polygon> surface;               ///< what of the shell bounds it
  std::shared_ptr<const MeshDistance> shell;  ///< of a tapered one, alone

  double lowest() const;   ///< of the section, along `up` [m]
  double highest() const;  ///< [m]
  /// The section's farthest point along out * `side` at a height of its own [m].
  double outermost(double height, double out) const;
  std::size_t strips() const { return borders.size() + 1; }
  bool is_tapered() const { return shell != nullptr; }
  /// Through the line `across` q = at of the section, unit `across`, and where that line is at `high`.
  Plane plane_through(const Point& across, double at) const;
  /// Its place in the section, as where a line through the tip, or along the axis, meets that.
  Point in_section(const Vector3& p) const;
  /// Distance to the prism, 0 inside [m].
  double distance(const Vector3& p) const;
  /// No point of the hull of these is farther from the shell's solid; infinite of a tapered one. The prism
  /// drawn in by `room` is inside; that leaves room / sin of half an angle at its edges, 4 at most, and with
  /// its ends less than 5 at corners.
  double bound(const std::array<Vector3, 8>& corners) const;
  /// Whether all of the hexahedron is within `limit` of the prism.
  bool is_about(const SixPlanes& solid, double limit) const;
  /// The slab that holds the points, strips first to last of them, with sides that leave least outside.
  SixPlanes slab(std::span<const Vector3> points, std::size_t first, std::size_t last) const;
};

/// Twice the area of a triangle of the section, positive where it goes around counter-clockwise.
inline double turn(const Prism::Point& a, const Prism::Point& b, const Prism::Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

}  // namespace touchstone::fit
