#include "touchstone/adapters/robot_formats/robot_formats.hpp"

#include <string>

#include "touchstone/contact_core/input_error.hpp"
#ifdef TOUCHSTONE_HAS_URDF
#include "touchstone/adapters/urdf/urdf.hpp"
#endif
#ifdef TOUCHSTONE_HAS_SDF
#include "touchstone/adapters/sdf/sdf.hpp"
#endif
#ifdef TOUCHSTONE_HAS_MJCF
#include "touchstone/adapters/mjcf/mjcf.hpp"
#endif

namespace touchstone {
namespace {

std::string extension_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  return extension;
}

[[noreturn, maybe_unused]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw InputError(file.string() + ": this build does not read " + what);
}

}  // namespace

Robot load_robot([[maybe_unused]] const std::filesystem::path& file,
                 [[maybe_unused]] const RobotOptions& options) {
  // By the file's ending; a format that this build lacks is named with the package that it needs.
  const std::string extension = extension_of(file);
  if (extension == ".urdf") {
#ifdef TOUCHSTONE_HAS_URDF
    return urdf::load_robot(file, options);
#else
    refuse(file, "URDF (Debian: liburdfdom-dev)");
#endif
  }
  if (extension == ".sdf") {
#ifdef TOUCHSTONE_HAS_SDF
    return sdf::load_robot(file, options);
#else
    refuse(file, "SDF (Debian: libtinyxml2-dev)");
#endif
  }
  if (extension == ".xml" || extension == ".mjcf") {
#ifdef TOUCHSTONE_HAS_MJCF
    return mjcf::load_robot(file, options);
#else
    refuse(file, "MJCF (Debian: libmujoco-dev)");
#endif
  }
  throw InputError(file.string() + ": a robot is read from .urdf, .sdf, .xml or .mjcf");
}

std::vector<ExemptPair> load_exempt_pairs([[maybe_unused]] const std::filesystem::path& srdf) {
#ifdef TOUCHSTONE_HAS_URDF
  return urdf::load_srdf(srdf);
#else
  refuse(srdf, "SRDF (Debian: liburdfdom-dev)");
#endif
}

bool is_robot_file(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".urdf" || extension == ".sdf" || extension == ".xml" || extension == ".mjcf";
}

}  // namespace touchstone
