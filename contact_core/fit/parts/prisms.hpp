#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/fit/space/six_planes.hpp"

// Private to contact_core/fit.

namespace touchstone::fit {

/// A closed shell that is a right prism on a convex polygon: a pin, a rod, a bar or a plate.
///
/// Its distance is a convex function, so a hexahedron keeps to a limit where its eight corners do: no place
/// between them is looked at. It is covered by slabs across its section, each between two of the section's
/// levels; so a round one of m facets within the limit takes m / 2 - 1.
struct Prism {
  Vector3 axis, up, side;  ///< unit; levels are along `up`, `side` is across both: up x side = axis
  double low, high;        ///< along the axis [m]
  std::vector<std::array<double, 2>> section;  ///< (up, side), counter-clockwise seen along -axis [m]
  std::vector<double> borders;  ///< of the strips between levels, ascending; not the outer ones
  Bounds box;
  double room;  ///< its surface is within this of what stands here [m]
  std::vector<std::uint32_t> triangles;

  double lowest() const;   ///< of the section, along `up` [m]
  double highest() const;  ///< [m]
  /// The section's farthest point along out * `side` at a height of its own [m].
  double outermost(double height, double out) const;
  std::size_t strips() const { return borders.size() + 1; }
  /// Distance to the prism, 0 inside [m].
  double distance(const Vector3& p) const;
  /// No point of the hull of these is farther from the shell's solid. The prism drawn in by `room` is inside;
  /// that leaves room / sin of half an angle at its edges, 4 at most, and with its ends less than 5 at
  /// corners.
  double bound(const std::array<Vector3, 8>& corners) const;
  /// Whether all of the hexahedron is within `limit` of the prism.
  bool is_about(const SixPlanes& solid, double limit) const;
  /// The slab that holds the points, strips first to last of them, with sides that leave least outside.
  SixPlanes slab(std::span<const Vector3> points, std::size_t first, std::size_t last) const;
};

/// The prisms of a mesh that are thick beside `over`: other hexahedra hardly hold parts of several. None is
/// near a shell that is inside out, as that may be its cavity.
std::vector<Prism> find_prisms(const MeshDistance& mesh, double over);

/// The mesh without these shells; nothing where none is left.
std::optional<MeshDistance> without(const MeshDistance& mesh, std::span<const Prism> prisms);

}  // namespace touchstone::fit
