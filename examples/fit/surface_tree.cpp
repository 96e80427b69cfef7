#include "touchstone/examples/fit/surface_tree.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::fitting {
namespace {

constexpr std::size_t kMostTriangles = 65'536;

/// The prism below a triangle; its fourth edge is collapsed.
Hexahedron plate(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& down) {
  const std::array<Vector3, 8> vertices = {a + down, b + down, c + down, c + down, a, b, c, c};
  return Hexahedron::from_vertices(vertices);
}

}  // namespace

std::optional<HexahedronTree> surface_tree(const TriangleMesh& mesh, double thickness,
                                           const std::string& name) {
  if (mesh.triangles.size() > kMostTriangles) return std::nullopt;
  std::vector<PlacedHexahedron> plates;
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3 across = cross(b - a, c - a);
    const double area = norm(across);
    if (area == 0.0) continue;
    try {
      plates.push_back(
          {fmt::format("t{}", plates.size()), plate(a, b, c, -thickness / area * across), Pose{}});
    } catch (const InputError&) {
      return std::nullopt;
    }
  }
  if (plates.empty()) return std::nullopt;
  return HexahedronTree(std::move(plates), name);
}

}  // namespace touchstone::fitting
