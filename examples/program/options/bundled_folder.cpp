#include "touchstone/examples/program/options/bundled_folder.hpp"

namespace touchstone::program {

namespace fs = std::filesystem;

fs::path program_folder() { return fs::canonical("/proc/self/exe").parent_path(); }

fs::path bundled_folder(const fs::path& checkout, const fs::path& folder) {
  const fs::path installed = program_folder().parent_path() / "share/touchstone/examples" / folder;
  std::error_code none;
  return fs::is_directory(installed, none) ? installed : checkout / folder;
}

}  // namespace touchstone::program
