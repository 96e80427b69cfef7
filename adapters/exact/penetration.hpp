#pragma once

// Private to adapters/exact.

#include "touchstone/adapters/exact/integer_vector.hpp"

namespace touchstone::exact {

/// The signed distance along a direction is height / |direction|.
struct DeepestDirection {
  IntegerVector direction;
  Integer height;  ///< min_j direction . b_j - max_i direction . a_i; <= 0
  int tied =
      0;  ///< how many distinct facet directions are exactly as good; 0 if the difference is at most a line
};

/// The direction of least overlap of two solids that meet.
/// @pre the solids have a point in common.
/// @param a,b  the vertices as doubles, of which `pair` is the integer form.
DeepestDirection find_deepest_direction(const IntegerPair& pair, const WorldVertices& a,
                                        const WorldVertices& b);

/// True if unit(u) comes after unit(v) in the order of x, then y, then z.
bool is_after(const IntegerVector& u, const IntegerVector& v);

}  // namespace touchstone::exact
