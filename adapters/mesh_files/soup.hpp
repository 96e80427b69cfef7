#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/vector.hpp"

// Private to this folder.

namespace touchstone::mesh_files {

/// Triangles as a file has them: in its unit and axes, nothing welded.
struct Soup {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::size_t polygons_split = 0;
  double relative_rounding = 0.0;  ///< of a coordinate, by the largest [1]
  bool states_unit = false;        ///< vertices are in metres already
};

/// The input of readers.
struct ReadTask {
  std::string file;  ///< for messages
  std::size_t most_triangles;
  const std::function<void(double)>* progress;  ///< never null; may hold nothing

  void advance(double share) const {
    if (*progress) (*progress)(share);
  }
  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail_triangle(std::size_t triangle, const std::string& reason) const;
  /// Called before triangle `index` is added. @throws InputError beyond most_triangles.
  void require_room(std::size_t index) const;
};

Soup read_obj(std::string_view bytes, const ReadTask& task);
Soup read_ply(std::string_view bytes, const ReadTask& task);
/// By assimp. @param turn_up the up axis that the file states becomes z.
Soup read_dae(const std::filesystem::path& file, std::string_view text, bool turn_up, const ReadTask& task);

}  // namespace touchstone::mesh_files
