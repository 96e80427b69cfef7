#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The manifest of a folder tells our files from everybody else's.

namespace touchstone::program {

/// The manifest's name within a folder: of a report, and of files that are written one after the other.
inline constexpr const char* kManifestName = "touchstone_report.json";
inline constexpr const char* kRecordsManifestName = "touchstone_records.json";

/// One file as it was written.
struct ManifestEntry {
  std::string name;  ///< relative to the folder, with '/'
  std::uintmax_t bytes = 0;
  std::string sha256;
};

/// The files that a run wrote into a folder. While a run replaces them a name stands twice: as it was and as
/// it becomes, so that a run that dies there leaves no file that nobody knows.
struct Manifest {
  std::string program;   ///< that wrote them
  bool complete = true;  ///< false: of a run that ended early
  std::vector<ManifestEntry> files;
};

ManifestEntry manifest_entry(const std::string& name, std::string_view content);

/// Returns the manifest of an earlier run in the folder; nothing when there is none.
/// @throws InputError for one that cannot be read or names files outside the folder.
std::optional<Manifest> read_manifest(const std::filesystem::path& folder, const char* name = kManifestName);

/// Whether a name from elsewhere, a manifest's or one made of somebody's data, stays in its folder.
bool stays_inside(const std::string& name);

std::string manifest_text(const Manifest& manifest);

/// The owner of a file that has the name of one of ours.
enum class FileOwner : std::uint8_t {
  free,     ///< nothing
  ours,     ///< a file of an earlier run, unchanged since
  changed,  ///< a file of an earlier run that somebody changed
  foreign   ///< anything else
};

/// Returns what stands at `name` in the folder. Links are not followed: a link is somebody's.
FileOwner owner_of(const std::filesystem::path& folder, const std::optional<Manifest>& manifest,
                   const std::string& name);

}  // namespace touchstone::program
