#include "touchstone/contact_core/native/solids/parallelepiped.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {

namespace {

constexpr double kFit = 16 * std::numeric_limits<double>::epsilon();

double sum(const Vector3& p) { return (std::abs(p.x()) + std::abs(p.y())) + std::abs(p.z()); }
double largest(const Vector3& p) { return std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())}); }

}  // namespace

std::optional<Parallelepiped> as_parallelepiped(const Hexahedron& solid) {
  const auto& v = solid.vertices();
  Parallelepiped out;
  out.centre = 0.5 * v[0] + 0.5 * v[7];
  for (int i = 0; i < 3; ++i) out.half_edges[i] = 0.5 * v[4 >> i] - 0.5 * v[0];
  for (int i = 0; i < 8; ++i) {
    Vector3 form = out.centre;
    for (int k = 0; k < 3; ++k) form += (i & (4 >> k) ? 1.0 : -1.0) * out.half_edges[k];
    out.deviation = std::max(out.deviation, largest(form - v[i]));
  }
  // Evaluating the parallelepiped rounds too: four sums of at most |centre| + three half edges.
  double reach = sum(out.centre);
  for (const Vector3& edge : out.half_edges) reach += sum(edge);
  out.deviation += 4 * kRoundoff * reach;
  if (!(out.deviation <= kFit * (solid.size() + reach))) return std::nullopt;
  return out;
}

}  // namespace touchstone::native
