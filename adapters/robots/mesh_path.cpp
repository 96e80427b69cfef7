#include "touchstone/adapters/robots/mesh_path.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using std::filesystem::path;

bool is_package(const path& folder, const std::string& name) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return false;
  const path plain = folder.lexically_normal();
  if ((plain.has_filename() ? plain : plain.parent_path()).filename() == name) return true;
  std::ifstream manifest(folder / "package.xml");
  const std::string text{std::istreambuf_iterator<char>(manifest), {}};
  return text.find("<name>" + name + "</name>") != std::string::npos;
}

void add_environment(const char* variable, const char* below, std::vector<path>& folders) {
  const char* value =
      std::getenv(variable);  // NOLINT(concurrency-mt-unsafe): set-up, and nobody sets it here
  if (!value) return;
  const std::string text = value;
  for (std::size_t first = 0; first <= text.size();) {
    const std::size_t end = std::min(text.find(':', first), text.size());
    if (end > first) folders.push_back(path(text.substr(first, end - first)) / below);
    first = end + 1;
  }
}

std::vector<path> folders_to_look_in(const path& robot, const std::vector<path>& package_paths) {
  std::vector<path> folders = package_paths;
  add_environment("ROS_PACKAGE_PATH", "", folders);
  add_environment("GAZEBO_MODEL_PATH", "", folders);
  add_environment("AMENT_PREFIX_PATH", "share", folders);
  std::error_code error;
  path above = std::filesystem::absolute(robot, error).lexically_normal().parent_path();
  for (; !above.empty() && above != above.parent_path(); above = above.parent_path())
    folders.push_back(above);
  return folders;
}

/// A relative name that climbs nowhere.
bool stays_below(const path& name) {
  const path inside = name.lexically_normal();
  return !inside.empty() && !inside.is_absolute() && *inside.begin() != "..";
}

path in_package(const std::string& uri, const std::string& rest, const path& robot,
                const std::vector<path>& package_paths) {
  const std::size_t slash = rest.find('/');
  const std::string name = rest.substr(0, slash);
  if (slash == std::string::npos || name.empty() || name == "." || name == "..")
    throw InputError("mesh '" + uri + "': names no package and file");
  const path inside = path(rest.substr(slash + 1)).lexically_normal();
  if (!stays_below(inside)) throw InputError("mesh '" + uri + "': leaves its package");
  std::string looked_in;
  std::error_code error;
  for (const path& folder : folders_to_look_in(robot, package_paths)) {
    for (const path& candidate : {folder / name, folder})
      if (is_package(candidate, name) && std::filesystem::exists(candidate / inside, error))
        return candidate / inside;
    looked_in += (looked_in.empty() ? "" : ", ") + folder.string();
  }
  throw InputError("mesh '" + uri + "': not found; looked for package '" + name + "' with it in " +
                   looked_in);
}

// %20 and the like as the bytes that they stand for; a zero byte stays as written, as it would end a name.
std::string decoded(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* const end = uri.data() + std::min(i + 3, uri.size());
    const bool is_code = uri[i] == '%' && i + 2 < uri.size() &&
                         std::from_chars(uri.data() + i + 1, end, value, 16).ptr == end && value != 0;
    text += is_code ? static_cast<char>(value) : uri[i];
    if (is_code) i += 2;
  }
  return text;
}

// In the robot's folder; else, where that is in a package, in those above it up to the package's: as of
// readers that take such names from there.
path at_relative(const std::string& name, const path& robot) {
  std::error_code error;
  path file = robot.parent_path() / name;
  const auto is_file = [&](const path& candidate) {
    return std::filesystem::is_regular_file(candidate, error);
  };
  if (is_file(file) || !stays_below(name)) return file;
  const path inside = path(name).lexically_normal();
  path found, above = std::filesystem::absolute(robot, error).lexically_normal().parent_path();
  for (; !above.empty() && above != above.parent_path(); above = above.parent_path()) {
    if (found.empty() && is_file(above / inside)) found = above / inside;
    if (is_file(above / "package.xml")) return found.empty() ? file : found;
  }
  return file;
}

path find_mesh(const std::string& uri, const path& robot, const std::vector<path>& package_paths) {
  for (const char* scheme : {"package://", "model://"})
    if (uri.starts_with(scheme))
      return in_package(uri, uri.substr(std::string(scheme).size()), robot, package_paths);
  const bool is_name = uri.find("://") == std::string::npos;
  path file;
  if (uri.starts_with("file://"))
    file = uri.substr(7);
  else if (is_name)
    file = at_relative(uri, robot);
  else
    throw InputError("mesh '" + uri + "': known are package://, model://, file:// and paths");
  std::error_code error;
  if (uri.empty() || !std::filesystem::is_regular_file(file, error))
    throw InputError(
        "mesh '" + uri + "': there is no file " + file.string() +
        (is_name && stays_below(uri) ? ", nor in a folder above up to one with a package.xml" : ""));
  return file;
}

}  // namespace

path mesh_path(const std::string& uri, const path& robot, const std::vector<path>& package_paths) {
  const std::string plain = uri.find("://") == std::string::npos ? uri : decoded(uri);
  if (plain == uri) return find_mesh(uri, robot, package_paths);
  try {
    return find_mesh(uri, robot, package_paths);
  } catch (const InputError&) {  // no file has the name as it is written
    return find_mesh(plain, robot, package_paths);
  }
}

}  // namespace touchstone
