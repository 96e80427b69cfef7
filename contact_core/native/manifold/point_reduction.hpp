#pragma once

#include <array>

namespace touchstone::native {

/// Corners of a convex polygon, in order.
struct FlatPolygon {
  static constexpr int kMost = 20;

  int count = 0;
  std::array<double, kMost> x, y;
};

using Choice = std::array<int, FlatPolygon::kMost>;  ///< indices of corners, ascending

/// Chooses the `wanted` corners whose hull has the largest area, `must` among them unless it is negative; of
/// two corners the largest distance, of one `must` or 0. Dynamic programming over the polygon's order,
/// O(wanted * count^2) with `must`, O(wanted * count^3) without; finds the largest of all choices. Of choices
/// equal to 1e-9 of the polygon's area it takes the first.
///
/// Four corners with any given one hold at least 1/2 of the polygon's area: with the given corner, the one
/// where a line parallel to some tangent there touches the other side, and the furthest on both sides of the
/// chord between them, the polygon lies in a parallelogram of twice the quadrangle's area. Three hold 1/4;
/// three freely chosen 3 sqrt(3) / (4 pi) (Sas 1939), n freely chosen n / (2 pi) sin(2 pi / n).
/// @pre 1 <= wanted <= polygon.count <= kMost
void choose_largest_polygon(const FlatPolygon& polygon, int wanted, int must, Choice& chosen);

}  // namespace touchstone::native
