#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

// Private to this folder.

namespace touchstone::scene_files {

/// [bytes] Room for tens of thousands of pairs.
inline constexpr std::uintmax_t kLargestFile = std::uintmax_t{64} << 20;

/// The whole file.
/// @throws InputError naming the file: it cannot be read, is not a regular file (a device or a pipe may never
/// end), or is larger than kLargestFile.
std::string read_text_file(const std::filesystem::path& path);

}  // namespace touchstone::scene_files
