#include "touchstone/contact_core/native/solids/solid_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

bool is_ordinary(const Hexahedron& solid) {
  return solid.size() >= kOrdinaryLow && largest(solid.bounding_sphere().centre) <= kOrdinaryHigh &&
         solid.size() <= kOrdinaryHigh;
}

BoxRecord box_record(const Hexahedron& solid, bool ordinary) {
  const Vector3& half = solid.half_extents();
  return {{half.x(), half.y(), half.z()}, ordinary ? (half.x() + half.y()) + half.z() : kInfinity};
}

ParallelepipedRecord form_record(const Parallelepiped& form, bool ordinary) {
  ParallelepipedRecord out{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) out.half_edges[i][k] = form.half_edges[i](k);
  for (int k = 0; k < 3; ++k) out.centre[k] = ordinary ? form.centre(k) : kInfinity;
  out.deviation = form.deviation;
  return out;
}

VertexRecord vertex_record(const Hexahedron& solid, bool ordinary) {
  VertexRecord out;
  for (int i = 0; i < 8; ++i) {
    const Vector3 v = ordinary ? solid.vertices()[i] : Vector3::Constant(kNaN);
    out.x[i] = v.x(), out.y[i] = v.y(), out.z[i] = v.z();
  }
  return out;
}

FormRecord edge_form_record(const Hexahedron& solid, const Parallelepiped& form, bool ordinary) {
  FormRecord out{};
  double reach = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double length = ordinary ? norm(form.half_edges[i]) : 0.0;
    for (int k = 0; k < 3; ++k)
      out.directions[i][k] = length > 0.0 ? form.half_edges[i](k) / length : form.half_edges[i](k);
    out.half_lengths[i] = ordinary ? length : kInfinity;
    out.centre[i] = form.centre(i);
    reach += length;
  }
  // Length and division round by 4 u.
  out.deviation = form.deviation + 4 * kRoundoff * reach;
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
  out.forms.reserve(solids.size());
  out.vertices.reserve(solids.size());
  out.edge_forms.reserve(solids.size());
  out.parallelepipeds.reserve(solids.size());
  out.solids.reserve(solids.size());
  for (const Hexahedron& solid : solids) {
    const bool ordinary = is_ordinary(solid);
    const std::optional<Parallelepiped> form = as_parallelepiped(solid);
    out.kinds.push_back(solid.is_box() ? SolidKind::box
                        : form         ? SolidKind::parallelepiped
                                       : SolidKind::general);
    out.ordinary.push_back(ordinary);
    out.boxes.push_back(box_record(solid, ordinary));
    out.parallelepipeds.push_back(form.value_or(Parallelepiped{}));
    out.forms.push_back(form_record(out.parallelepipeds.back(), ordinary));
    out.vertices.push_back(vertex_record(solid, ordinary));
    out.edge_forms.push_back(edge_form_record(solid, out.parallelepipeds.back(), ordinary && form));
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
  put(set.boxes, fresh.boxes), put(set.forms, fresh.forms);
  put(set.vertices, fresh.vertices), put(set.edge_forms, fresh.edge_forms);
  put(set.parallelepipeds, fresh.parallelepipeds), put(set.solids, fresh.solids);
}

}  // namespace touchstone::native
