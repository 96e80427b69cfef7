#pragma once

#include <random>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// Pairs of vertex sets at and around touching: what a floating-point filter leaves undecided.

namespace touchstone::numerics {

using Random = std::mt19937_64;

struct HullPair {
  WorldVertices a, b;
};

int random_int(Random& random, int low, int high);

/// Eight points of {0 .. range}^3 each, in a random subspace: points, segments, polygons and solids, many
/// coincident, collinear and coplanar.
HullPair grid_pair(Random& random, int range);

/// The same after an exact map by an integer matrix with entries up to 2^bits: ties on directions that are
/// not aligned with an axis.
HullPair mapped_grid_pair(Random& random, int range, int bits);

/// Boxes with sides and corners on a small grid, so that faces, edges and vertices often touch exactly, then
/// scaled by `unit` and rounded.
HullPair aligned_box_pair(Random& random, double unit);

/// The same pair under one rotation, rounded: exact contacts become gaps and overlaps of an ulp.
HullPair rotated_box_pair(Random& random);

/// A solid box or sheared, tapered and warped hexahedron of size about 1 at the origin.
WorldVertices random_hexahedron(Random& random);
WorldVertices translated(const WorldVertices& hull, const Vector3& by);
/// Multiplied by 2^exponent (rounded where denormal).
WorldVertices scaled(const WorldVertices& hull, int exponent);
WorldVertices permuted(const WorldVertices& hull, Random& random);

/// Every coordinate with its own exponent in [low, high].
HullPair scattered_pair(Random& random, int low, int high);

}  // namespace touchstone::numerics
