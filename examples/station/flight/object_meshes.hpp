#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/triangle_mesh.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::station {

/// Most triangles that a page is sent of a scene: 9 MB. Drawn by software these take a picture seconds, so
/// that the page leaves them out (page/pace.js).
inline constexpr std::size_t kMostTriangles = 250'000;
/// A mesh further from its object's origin is left out: squares of floats overflow from 1.8e19 on [m].
inline constexpr double kFarthestCorner = 1e15;

/// A surface that a picture shows of an object.
struct ObjectMesh {
  std::uint32_t object;
  Pose X_OM;
  std::shared_ptr<const TriangleMesh> mesh;  ///< [m]
};

/// The surfaces that a picture shows instead of the hexahedra that cover them.
struct ObjectMeshes {
  std::vector<std::uint32_t> objects;   ///< that have one; ascending
  std::size_t triangles = 0;            ///< of all
  std::vector<std::uint32_t> left_out;  ///< objects for whose meshes there was no room
  std::string bytes;                    ///< as protocol.md has them; empty: none
  std::string path;                     ///< where the server has them: "meshes/" and their hash
};

/// Those of an object go together; objects come in their order until kMostTriangles.
ObjectMeshes place_meshes(const std::vector<ObjectMesh>& meshes);

/// A list of {"object", "mesh": a file, relative to this one, "metres_per_unit"; "up": the file's axis that
/// is the object's z, left out: as written}. The mesh's frame is the object's; it is shown instead of all of
/// its hexahedra.
/// @param on_missing gets a line of each mesh whose file is not there, and which is left out; may be empty.
/// @return empty: there is no such file. @throws InputError naming the file: what it cannot mean, an object
/// that stands twice, and as load_mesh().
std::vector<ObjectMesh> read_meshes(const std::filesystem::path& file, const training::Setting& setting,
                                    const std::function<void(const std::string&)>& on_missing = {});

}  // namespace touchstone::station
