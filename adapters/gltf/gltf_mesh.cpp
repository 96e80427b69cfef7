#include "touchstone/adapters/gltf/gltf_mesh.hpp"

#include <numbers>

#include "touchstone/contact_core/geometry/trigonometry.hpp"

namespace touchstone::gltf {
namespace {

/// Corners of two triangles of a face, as places in its loop.
constexpr std::array<std::uint8_t, 6> kAcross02{0, 1, 2, 0, 2, 3};
constexpr std::array<std::uint8_t, 6> kAcross13{0, 1, 3, 1, 2, 3};

/// The diagonal that lies outside: with it the other corners are below both triangles.
const std::array<std::uint8_t, 6>& triangles_of(const Hexahedron& solid, int face) {
  const auto corner = [&](int i) -> const Vector3& {
    return solid
        .vertices()[Hexahedron::kFaceVertices[static_cast<std::size_t>(face)][static_cast<std::size_t>(i)]];
  };
  const Vector3 normal = cross(corner(1) - corner(0), corner(2) - corner(0));
  return dot(normal, corner(3) - corner(0)) <= 0.0 ? kAcross02 : kAcross13;
}

void add_vertex(const PlacedHexahedron& placed, const Vector3& p_S, Mesh& mesh) {
  const Vector3 p_O = transform(placed.X_OS, p_S);
  for (int i = 0; i < 3; ++i) mesh.positions.push_back(static_cast<float>(p_O(i)));
}

/// Of a rounded solid the surface's point with this outward normal (of a flat spot's, a corner's).
Vector3 surface_point(const Hexahedron& solid, const Vector3& n) {
  const Vector3* furthest = solid.vertices().data();
  for (const Vector3& v : solid.vertices())
    if (dot(n, v) > dot(n, *furthest)) furthest = &v;
  return *furthest + solid.radius() * n;
}

constexpr std::uint32_t kMeridians = 16, kParallels = 8;

/// Points of the surface by their normals, on meridians and parallels that lie off the axes: where a box has
/// flat sides, quadrangles span these. Poles close it.
void add_rounded(const PlacedHexahedron& placed, Mesh& mesh) {
  // Vertices lie where normals point along parallels and meridians, without the poles.
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (std::uint32_t j = 0; j < kParallels; ++j)
    for (std::uint32_t k = 0; k < kMeridians; ++k) {
      const double up = ((j + 0.5) / kParallels - 0.5) * std::numbers::pi;
      const double round = (k + 0.5) * (2.0 * std::numbers::pi / kMeridians);
      const auto [height, across] = sine_cosine(up);
      const auto [y, x] = sine_cosine(round);
      const Vector3 n(across * x, across * y, height);
      add_vertex(placed, surface_point(placed.solid, n), mesh);
    }
  const auto index = [&](std::uint32_t j, std::uint32_t k) {
    return first + j * kMeridians + k % kMeridians;
  };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
  };
  // A cell between two parallels is two triangles.
  for (std::uint32_t j = 0; j + 1 < kParallels; ++j)
    for (std::uint32_t k = 0; k < kMeridians; ++k) {
      add(index(j, k), index(j, k + 1), index(j + 1, k + 1));
      add(index(j, k), index(j + 1, k + 1), index(j + 1, k));
    }
  // Fans close both ends, in place of the poles.
  for (std::uint32_t k = 1; k + 1 < kMeridians; ++k) {
    add(index(0, 0), index(0, k + 1), index(0, k));
    add(index(kParallels - 1, 0), index(kParallels - 1, k), index(kParallels - 1, k + 1));
  }
}

void add(const PlacedHexahedron& placed, Mesh& mesh) {
  if (placed.solid.is_rounded()) return add_rounded(placed, mesh);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (const Vector3& vertex : placed.solid.vertices()) add_vertex(placed, vertex, mesh);
  for (int face = 0; face < 6; ++face) {
    for (const std::uint8_t corner : triangles_of(placed.solid, face))
      mesh.indices.push_back(first + Hexahedron::kFaceVertices[static_cast<std::size_t>(face)][corner]);
  }
}

}  // namespace

Mesh make_mesh(const HexahedronTree& tree) {
  Mesh mesh;
  for (const PlacedHexahedron& placed : tree.solids()) add(placed, mesh);
  return mesh;
}

}  // namespace touchstone::gltf
