#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// Where a set of a corpus comes from: a family of pairs or of paths, or files of pairs.
struct PlannedSet {
  std::string name, description;
  std::string family;  ///< empty: of files
  std::uint64_t seed = 0;
  std::size_t count = 0;
  std::size_t poses = 1;  ///< more: a family of paths, of this many poses each
  std::vector<std::filesystem::path> files;
  std::string pairs_sha256, truth_sha256, impacts_sha256;  ///< empty: not frozen yet

  bool is_paths() const { return poses > 1; }
};

/// A corpus before its files are written: a manifest, perhaps without hashes.
struct CorpusPlan {
  std::string name, version;
  std::vector<PlannedSet> sets;
  Json manifest;
};

/// Reads a manifest. Files are relative to its folder.
/// @throws InputError naming file and field.
CorpusPlan load_plan(const std::filesystem::path& manifest);

}  // namespace touchstone::comparison
