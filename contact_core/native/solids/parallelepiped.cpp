#include "touchstone/contact_core/native/solids/parallelepiped.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {
namespace {

constexpr double kFit = 16 * std::numeric_limits<double>::epsilon();

}  // namespace

std::optional<Parallelepiped> as_parallelepiped(const WorldVertices& vertices_S, double size) {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) v[i] = vertices_S.vertex(i);
  Parallelepiped out{};
  const Vector3 centre = 0.5 * v[0] + 0.5 * v[7];
  std::array<Vector3, 3> half_edges;
  for (int i = 0; i < 3; ++i) half_edges[i] = 0.5 * v[4 >> i] - 0.5 * v[0];
  for (int i = 0; i < 8; ++i) {
    Vector3 corner = centre;
    for (int k = 0; k < 3; ++k) corner += (i & (4 >> k) ? 1.0 : -1.0) * half_edges[k];
    out.deviation = std::max(out.deviation, norm_inf(corner - v[i]));
  }
  // Evaluating the parallelepiped rounds too: four sums of at most |centre| + three half edges.
  double reach = norm_1(centre);
  for (const Vector3& edge : half_edges) reach += norm_1(edge);
  out.deviation += 4 * kRoundoff * reach;
  if (!(out.deviation <= kFit * (size + reach))) return std::nullopt;
  for (int k = 0; k < 3; ++k) {
    out.centre[k] = centre(k);
    for (int i = 0; i < 3; ++i) out.half_edges[i][k] = half_edges[i](k);
  }
  return out;
}

}  // namespace touchstone::native
