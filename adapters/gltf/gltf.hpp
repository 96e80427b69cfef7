#pragma once

#include <memory>
#include <span>
#include <string>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/output/recording.hpp"

namespace touchstone {

/// How write_gltf() reads the world.
struct GltfOptions {
  /// The world's z is up: a root node turns it to glTF's y. Otherwise the world's y is.
  bool is_z_up = true;
};

/// Writes a recorded run as a glTF 2.0 animation, one file with its buffer inside, for any viewer.
///
/// A node per object, its hexahedra as one mesh of triangles without normals (viewers shade them flat).
/// Objects that move have a translation and a rotation sampler, linear between frames, with a key a frame;
/// those that are missing from some frames also a scale sampler, 0 there. Seconds from the first frame on.
/// glTF holds floats: positions are rounded by at most 2^-24 of each coordinate (1e-6 m at 16 m), and a frame
/// whose time does not differ from the one before as a float is left out. For looking at, not for measuring.
///
/// @param trees those of all recorded objects, by their names; more may be there.
/// @throws InputError: no frame, an object without a tree, times that fall, a file that cannot be written.
void write_gltf(const std::string& path, const Recording& recording,
                std::span<const std::shared_ptr<const HexahedronTree>> trees,
                const GltfOptions& options = {});

}  // namespace touchstone
