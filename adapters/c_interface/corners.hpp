#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::c_interface {

/// Doubles of a solid: x, y, z of its eight corners.
inline constexpr std::size_t kCornerDoubles = 24;

/// The solids of `corners`, kCornerDoubles each [m]; a box where they are exactly a centred one's.
/// @param radii none, or one a solid [m]: 0 is not rounded; of a rounded one the centred box may be flat.
/// @throws InputError naming the solid by its index, the face or vertex and the figure.
std::vector<Hexahedron> solids_from_corners(std::span<const double> corners,
                                            std::span<const double> radii = {});

/// The inverse, in the order of Hexahedron::vertices().
std::vector<double> corners_of(std::span<const Hexahedron> solids);

}  // namespace touchstone::c_interface
