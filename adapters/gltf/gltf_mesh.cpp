#include "touchstone/adapters/gltf/gltf_mesh.hpp"

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

void add(const PlacedHexahedron& placed, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (const Vector3& vertex : placed.solid.vertices()) {
    const Vector3 p_O = transform(placed.X_OS, vertex);
    for (int i = 0; i < 3; ++i) mesh.positions.push_back(static_cast<float>(p_O(i)));
  }
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
