#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace touchstone {

/// A folder for a Browser's profile, which goes when its owner does.
class TemporaryProfile {
 public:
  /// @param program whose it is: the folder's name begins so. @throws std::runtime_error: none can be made.
  explicit TemporaryProfile(const std::string& program) {
    std::string name = (std::filesystem::temp_directory_path() / (program + ".XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder can be made: " + name);
    path_ = name;
  }
  ~TemporaryProfile() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryProfile(const TemporaryProfile&) = delete;
  TemporaryProfile& operator=(const TemporaryProfile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace touchstone
