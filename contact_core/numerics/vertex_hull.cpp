#include "touchstone/contact_core/numerics/vertex_hull.hpp"

#include <bit>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::numerics {
namespace {

using Difference = VertexHull::Difference;
using Facet = VertexHull::Facet;

struct Sides {
  std::uint8_t above = 0, below = 0, on = 0;
};

/// Where the points lie relative to the plane of points i, j, k (local indices).
Sides sides_of_plane(DifferenceDeterminant& determinant, int first, int i, int j, int k) {
  Sides out;
  DirectionSigns signs(determinant, {first + i, first + j}, {first + i, first + k});
  for (int l = 0; l < 8; ++l) {
    const int side = l == i || l == j || l == k ? 0 : signs.sign({first + i, first + l});
    (side > 0 ? out.above : side < 0 ? out.below : out.on) |= static_cast<std::uint8_t>(1 << l);
  }
  return out;
}

void add_facet(VertexHull& hull, int i, int j, int k, int inner, std::uint8_t on_plane) {
  hull.facets[hull.facet_count++] = {hull.first + i, hull.first + j, hull.first + k, inner, on_plane};
}

/// The facets as a hexahedron's six faces in the order of Hexahedron, each flat or broken along the diagonal
/// that bulges out. True when that is the hull: every triangle (or flat quad) has all other vertices strictly
/// on one and the same side. Why this suffices: they are then facets. Two faces that share an edge share no
/// third vertex, so the neighbour across each side of a quad has the quad's other vertices strictly inside
/// its plane: the quad is convex, and its sides are edges. So every edge of every one of these facets has a
/// neighbour among them: they are all facets.
bool make_hexahedral_facets(DifferenceDeterminant& determinant, VertexHull& hull) {
  const int first = hull.first;
  // The corner at vertex 0: counter-clockwise seen from outside, or mirrored.
  const int inner = determinant.sign({first, first + 1}, {first, first + 2}, {first, first + 4});
  if (inner == 0) return false;
  for (const auto& face : Hexahedron::kFaceVertices) {
    const auto [a, b, c, d] = face;
    const int fourth =
        determinant.sign({first + a, first + b}, {first + a, first + c}, {first + a, first + d});
    // Broken along a-c when the plane of a, b, c has d inside.
    const bool along_ac = fourth == inner;
    const std::array<std::array<int, 3>, 2> triangles =
        along_ac ? std::array<std::array<int, 3>, 2>{{{a, b, c}, {a, c, d}}}
                 : std::array<std::array<int, 3>, 2>{{{a, b, d}, {b, c, d}}};
    const auto quad = static_cast<std::uint8_t>(1 << a | 1 << b | 1 << c | 1 << d);
    for (int t = 0; t < (fourth == 0 ? 1 : 2); ++t) {
      const auto [i, j, k] = triangles[t];
      const auto on_plane = fourth == 0 ? quad : static_cast<std::uint8_t>(1 << i | 1 << j | 1 << k);
      DirectionSigns signs(determinant, {first + i, first + j}, {first + i, first + k});
      for (int l = 0; l < 8; ++l) {
        if (quad >> l & 1) continue;  // on the plane, or inside by the choice of the diagonal
        if (signs.sign({first + i, first + l}) != inner) return false;
      }
      add_facet(hull, i, j, k, inner, on_plane);
    }
  }
  return true;
}

/// Every triple of points that supports the hull, one per plane. None: the hull has no volume.
void make_general_facets(DifferenceDeterminant& determinant, VertexHull& hull) {
  hull.facet_count = 0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      for (int k = j + 1; k < 8; ++k) {
        bool known = false;
        for (int f = 0; f < hull.facet_count && !known; ++f)
          known = (~hull.facets[f].on_plane & (1 << i | 1 << j | 1 << k)) == 0;
        if (known) continue;
        const Sides sides = sides_of_plane(determinant, hull.first, i, j, k);
        if ((sides.above == 0) != (sides.below == 0))
          add_facet(hull, i, j, k, sides.above != 0 ? 1 : -1, sides.on);
      }
    }
  }
}

/// Two facets meet in a common face of the hull: if they share two different points, in an edge.
void make_edges(const DifferenceDeterminant& determinant, VertexHull& hull) {
  for (int f = 0; f < hull.facet_count; ++f) {
    for (int g = f + 1; g < hull.facet_count; ++g) {
      unsigned shared = hull.facets[f].on_plane & hull.facets[g].on_plane;
      if (std::popcount(shared) < 2) continue;
      const int p = hull.first + std::countr_zero(shared);
      for (shared &= shared - 1; shared != 0; shared &= shared - 1) {
        const Difference line{p, hull.first + std::countr_zero(shared)};
        if (determinant.is_zero(line)) continue;
        hull.edges[hull.edge_count++] = {line, {f, g}};
        break;
      }
    }
  }
}

void make_polygon_sides(DifferenceDeterminant& determinant, VertexHull& hull) {
  for (int p = hull.first; p < hull.first + 8; ++p) {
    for (int q = p + 1; q < hull.first + 8; ++q) {
      const Difference line{p, q};
      if (determinant.is_zero(line)) continue;
      bool left = false, right = false;
      for (int l = hull.first; l < hull.first + 8 && !(left && right); ++l) {
        const int side = l == p || l == q ? 0 : determinant.cross_sign(line, {p, l}, hull.plane_axis);
        left = left || side > 0;
        right = right || side < 0;
      }
      if (!(left && right)) hull.edges[hull.edge_count++] = {line, {-1, -1}};
    }
  }
}

void make_flat_hull(DifferenceDeterminant& determinant, VertexHull& hull) {
  for (int l = hull.first + 1; l < hull.first + 8; ++l) {
    const Difference u{hull.first, l};
    if (hull.rank == 0) {
      if (determinant.is_zero(u)) continue;
      hull.span[0] = u;
      hull.rank = 1;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (determinant.cross_sign(hull.span[0], u, axis) == 0) continue;
      hull.span[1] = u;
      hull.plane_axis = axis;
      hull.rank = 2;
      make_polygon_sides(determinant, hull);
      return;
    }
  }
  if (hull.rank == 1) hull.edges[hull.edge_count++] = {hull.span[0], {-1, -1}};
}

}  // namespace

VertexHull make_vertex_hull(DifferenceDeterminant& determinant, int first) noexcept {
  VertexHull hull;
  hull.first = first;
  if (!make_hexahedral_facets(determinant, hull)) make_general_facets(determinant, hull);
  if (hull.facet_count > 0) {
    hull.rank = 3;
    make_edges(determinant, hull);
  } else {
    make_flat_hull(determinant, hull);
  }
  return hull;
}

}  // namespace touchstone::numerics
