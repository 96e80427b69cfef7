#pragma once

#include <filesystem>
#include <optional>

#include "touchstone/contact_core/fit/fit.hpp"

namespace touchstone::robot_files {

/// Covers of meshes in a folder that the user names, a file each: `SHA256.cover.json`, the hash of the mesh
/// in metres and of what was asked of its cover. Files that are there are never written to.
class KeptCovers {
 public:
  /// @throws InputError where the path is no folder and none can be made.
  explicit KeptCovers(std::filesystem::path folder);

  /// None: none is kept. @throws InputError naming the file: unreadable, malformed, of another mesh.
  std::optional<Fit> find(const TriangleMesh& mesh, const FitOptions& asked) const;
  /// Under a temporary name first, so that no half of a file is ever found.
  /// @throws InputError naming the file, where the system refuses.
  void keep(const TriangleMesh& mesh, const FitOptions& asked, const Fit& fit) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace touchstone::robot_files
