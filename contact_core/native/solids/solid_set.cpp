#include "touchstone/contact_core/native/solids/solid_set.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {
namespace {

bool is_ordinary(const Hexahedron& solid) {
  return solid.size() >= kOrdinaryLow && norm_inf(solid.bounding_sphere().centre) <= kOrdinaryHigh &&
         solid.size() <= kOrdinaryHigh;
}

BoxRecord box_record(const Hexahedron& solid, bool ordinary) {
  const Vector3& half = solid.half_extents();
  return {{half.x(), half.y(), half.z()}, ordinary ? (half.x() + half.y()) + half.z() : kInfinity};
}

VertexRecord vertex_record(const Hexahedron& solid, bool ordinary) {
  VertexRecord out;
  for (int i = 0; i < 8; ++i) {
    const Vector3 v = ordinary ? solid.vertices()[i] : Vector3::Constant(kNaN);
    out.x[i] = v.x(), out.y[i] = v.y(), out.z[i] = v.z();
  }
  return out;
}

ParallelepipedEdges edges_record(const Hexahedron& solid, const Parallelepiped& shape, bool ordinary) {
  ParallelepipedEdges out{};
  double reach = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double length = ordinary ? norm(vector_of(shape.half_edges[i])) : 0.0;
    for (int k = 0; k < 3; ++k)
      out.directions[i][k] = length > 0.0 ? shape.half_edges[i][k] / length : shape.half_edges[i][k];
    out.half_lengths[i] = ordinary ? length : kInfinity;
    out.centre[i] = shape.centre[i];
    reach += length;
  }
  // Length and division round by 4 u.
  out.deviation = shape.deviation + 4 * kRoundoff * reach;
  for (int i = 0; i < 8; ++i) {
    const Vector3& v = solid.vertices()[i];
    out.x[i] = v.x(), out.y[i] = v.y(), out.z[i] = v.z();
  }
  return out;
}

}  // namespace

SolidSet make_solid_set(std::span<const Hexahedron> solids) {
  SolidSet out;
  out.kinds.reserve(solids.size());
  out.ordinary.reserve(solids.size());
  out.boxes.reserve(solids.size());
  out.vertices.reserve(solids.size());
  out.parallelepiped_edges.reserve(solids.size());
  out.parallelepipeds.reserve(solids.size());
  out.solids.reserve(solids.size());
  for (const Hexahedron& solid : solids) {
    const bool ordinary = is_ordinary(solid);
    const std::optional<Parallelepiped> fit = as_parallelepiped(solid);
    out.kinds.push_back(solid.is_box() ? SolidKind::box
                        : fit          ? SolidKind::parallelepiped
                                       : SolidKind::general);
    out.ordinary.push_back(ordinary);
    out.boxes.push_back(box_record(solid, ordinary));
    Parallelepiped& parallelepiped = out.parallelepipeds.emplace_back(fit.value_or(Parallelepiped{}));
    out.vertices.push_back(vertex_record(solid, ordinary));
    out.parallelepiped_edges.push_back(edges_record(solid, parallelepiped, ordinary && fit));
    if (!ordinary) std::fill_n(parallelepiped.centre, 3, kInfinity);
    HullRecord hull;
    const SolidFeatures features = find_features(solid, &hull);
    out.solids.push_back({in_columns(solid), hull, solid, features});
  }
  return out;
}

void set_solids(SolidSet& set, std::size_t first, std::span<const Hexahedron> solids) {
  const SolidSet fresh = make_solid_set(solids);
  const auto put = [first](auto& to, const auto& from) {
    const std::size_t replaced = std::min(from.size(), to.size() - first);
    const auto split = from.begin() + static_cast<std::ptrdiff_t>(replaced);
    std::copy(from.begin(), split, to.begin() + static_cast<std::ptrdiff_t>(first));
    to.insert(to.end(), split, from.end());
  };
  put(set.kinds, fresh.kinds), put(set.ordinary, fresh.ordinary);
  put(set.boxes, fresh.boxes), put(set.parallelepipeds, fresh.parallelepipeds);
  put(set.vertices, fresh.vertices), put(set.parallelepiped_edges, fresh.parallelepiped_edges);
  put(set.solids, fresh.solids);
}

}  // namespace touchstone::native
