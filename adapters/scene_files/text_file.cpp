#include "touchstone/adapters/scene_files/text_file.hpp"

#include <fstream>
#include <system_error>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::scene_files {

std::string read_text_file(const std::filesystem::path& path) {
  const auto refuse = [&](const std::string& reason) { throw InputError(path.string() + ": " + reason); };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) refuse("cannot be read");
  if (!std::filesystem::is_regular_file(status)) refuse("cannot be read: not a regular file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) refuse("cannot be read");
  // The bytes read count, not the size that the file system gives: a file may grow.
  std::string text;
  for (std::string block(1 << 16, '\0'); stream;) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block, 0, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kLargestFile)
      refuse("cannot be read: larger than " + std::to_string(kLargestFile >> 20) + " MiB");
  }
  if (stream.bad()) refuse("cannot be read");
  return text;
}

}  // namespace touchstone::scene_files
