#include "touchstone/contact_core/numerics/flat_hulls.hpp"

namespace touchstone::numerics {
namespace {

using Difference = VertexHull::Difference;

/// The differences that span the directions of both hulls, ranks at most 2.
struct Span {
  std::array<Difference, 4> line;
  int count = 0;
};

Span joint_span(const VertexHull& a, const VertexHull& b) {
  Span out;
  for (const VertexHull* hull : {&a, &b})
    for (int i = 0; i < hull->rank; ++i) out.line[out.count++] = hull->span[i];
  return out;
}

/// Both hulls are in one plane, on which dropping `axis` is injective. Two disjoint polygons (or segments or
/// points, as long as {b - a} is two-dimensional) have the origin strictly beyond some side of {b - a}, which
/// is parallel to a side of one of them: then all b_j - a_i are strictly on one side of that line.
bool polygons_intersect(DifferenceDeterminant& determinant, const VertexHull& a, const VertexHull& b,
                        int axis) {
  const auto separates = [&](Difference line) {
    int side = 0;
    for (int i = a.first; i < a.first + 8; ++i) {
      for (int j = b.first; j < b.first + 8; ++j) {
        const int s = determinant.cross_sign(line, {i, j}, axis);
        if (s == 0 || s == -side) return false;
        side = s;
      }
    }
    return true;
  };
  for (const VertexHull* hull : {&a, &b})
    for (int e = 0; e < hull->edge_count; ++e)
      if (separates(hull->edges[e].line)) return false;
  return true;
}

/// Both hulls are on one line on which component `axis` is injective: intervals.
bool segments_intersect(const DifferenceDeterminant& determinant, const VertexHull& a, const VertexHull& b,
                        int axis) {
  bool some_b_not_below = false, some_b_not_above = false;
  for (int i = a.first; i < a.first + 8; ++i) {
    for (int j = b.first; j < b.first + 8; ++j) {
      const int s = determinant.component_sign({i, j}, axis);
      some_b_not_below = some_b_not_below || s >= 0;
      some_b_not_above = some_b_not_above || s <= 0;
    }
  }
  return some_b_not_below && some_b_not_above;
}

}  // namespace

bool span_no_volume(DifferenceDeterminant& determinant, const VertexHull& a, const VertexHull& b) noexcept {
  if (a.rank == 3 || b.rank == 3) return false;
  const Span span = joint_span(a, b);
  for (int i = 0; i < span.count; ++i)
    for (int j = i + 1; j < span.count; ++j)
      for (int k = j + 1; k < span.count; ++k)
        if (determinant.sign(span.line[i], span.line[j], span.line[k]) != 0) return false;
  return true;
}

bool flat_hulls_intersect(DifferenceDeterminant& determinant, const VertexHull& a,
                          const VertexHull& b) noexcept {
  const Difference b_minus_a{a.first, b.first};
  const Span span = joint_span(a, b);
  for (int i = 0; i < span.count; ++i) {
    for (int j = i + 1; j < span.count; ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        if (determinant.cross_sign(span.line[i], span.line[j], axis) == 0) continue;
        const bool one_plane = determinant.sign(span.line[i], span.line[j], b_minus_a) == 0;
        return one_plane && polygons_intersect(determinant, a, b, axis);
      }
    }
  }
  if (span.count == 0) return determinant.is_zero(b_minus_a);
  for (int axis = 0; axis < 3; ++axis)
    if (determinant.cross_sign(span.line[0], b_minus_a, axis) != 0) return false;  // different parallel lines
  int axis = 0;
  while (determinant.component_sign(span.line[0], axis) == 0) ++axis;
  return segments_intersect(determinant, a, b, axis);
}

}  // namespace touchstone::numerics
