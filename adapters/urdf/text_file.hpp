#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::urdf {

/// @throws InputError naming the file.
inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (!stream || !(text << stream.rdbuf())) throw InputError(file.string() + ": cannot be read");
  return text.str();
}

}  // namespace touchstone::urdf
