#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

// For the readers of robots.

namespace touchstone {

/// @throws InputError naming the file: not there, no file, or not to be read.
inline std::string read_robot_text(const std::filesystem::path& file) {
  std::error_code error;
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(file, error) || !stream || !(text << stream.rdbuf()))
    throw InputError(file.string() + ": cannot be read");
  return text.str();
}

}  // namespace touchstone
