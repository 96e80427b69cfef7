#include "touchstone/contact_core/fit/meshes/main_axes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace touchstone::fit {
namespace {

constexpr double kAlong = 0.9998;  // cosine: a facet faces an axis
constexpr double kMost = 0.5;      // of the area, at least
constexpr double kMore = 1.5;      // times as much as along the coordinates' axes

// Of the area, what faces one of the axes.
double share_along(const TriangleMesh& mesh, const Matrix3& axes) {
  double all = 0.0, along = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3 n = area_vector(mesh, t);
    const double area = norm(n);
    all += area;
    double most = 0.0;
    for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(dot(Vector3(axes.row(i)), n)));
    if (most > kAlong * area) along += area;
  }
  return all > 0.0 ? along / all : 0.0;
}

}  // namespace

// The direction that most area faces, up to sign, among those across `across` (zero: any).
Vector3 main_direction(const TriangleMesh& mesh, const Vector3& across) {
  std::vector<std::pair<Vector3, double>> bins;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3 n = area_vector(mesh, t);
    const double area = norm(n);
    if (area == 0.0 || std::abs(dot(n, across)) > 0.05 * area) continue;
    const auto like = [&](const auto& bin) { return std::abs(dot(bin.first, n)) > kAlong * area; };
    const auto found = std::find_if(bins.begin(), bins.end(), like);
    if (found != bins.end())
      found->second += area;
    else if (bins.size() < 500)
      bins.emplace_back(n / area, area);
  }
  const auto most = std::max_element(bins.begin(), bins.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == bins.end() ? Vector3(Vector3::Zero()) : most->first;
}

std::optional<Matrix3> turned_frame(const TriangleMesh& mesh) {
  const double least = std::max(kMost, kMore * share_along(mesh, Matrix3::Identity()));
  if (least > 1.0) return std::nullopt;
  const Vector3 z = main_direction(mesh, Vector3::Zero());
  if (norm(z) == 0.0) return std::nullopt;
  Vector3 x = main_direction(mesh, z);
  x -= dot(x, z) * z;
  if (norm(x) < 0.5) return std::nullopt;
  x /= norm(x);
  Matrix3 axes;
  axes.row(0) = x.transpose();
  axes.row(1) = cross(z, x).transpose();
  axes.row(2) = z.transpose();
  if (share_along(mesh, axes) < least) return std::nullopt;
  return axes;
}

}  // namespace touchstone::fit
