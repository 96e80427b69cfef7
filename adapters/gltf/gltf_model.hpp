#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "touchstone/adapters/gltf/gltf.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

namespace touchstone {

/// Triangles of one look in a glTF model.
struct GltfPart {
  std::string name;                                     ///< of its node, mesh and material
  std::vector<Vector3> vertices;                        ///< in the model's frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside
  /// Red, green, blue, linear, 0 to 1: one a vertex, or one for all.
  std::vector<std::array<float, 3>> colours;
  float opacity = 1.0F;  ///< below 1 it is blended, and seen from both sides
};

/// A glTF 2.0 file's text with its buffer inside: a node and a mesh a part, nothing moves. Coordinates are
/// rounded to floats. For looking at, not for measuring.
/// @throws InputError naming the part: no triangle, an invalid index, colours that are neither one nor
/// as many as vertices.
std::string gltf_model(std::span<const GltfPart> parts, const GltfOptions& options = {});

}  // namespace touchstone
