#include "touchstone/examples/program/options/choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::program {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const BundledFiles& bundled) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(bundled.folder, error))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  if (error)
    throw InputError(fmt::format("{} {}: cannot be read", bundled.folder_option, bundled.folder.string()));
  std::sort(files.begin(), files.end());
  return files;
}

bool means(const std::string& wanted, const fs::path& file) {
  const std::string name = file.stem().string();
  if (wanted == name) return true;
  const auto without_zeros = [](const std::string& text) {
    return text.substr(std::min(text.find_first_not_of('0'), text.size()));
  };
  return without_zeros(wanted) == without_zeros(name.substr(0, name.find('_')));
}

}  // namespace

std::vector<fs::path> choose_files(const BundledFiles& bundled, const std::vector<std::string>& wanted) {
  const std::vector<fs::path> known = files_in(bundled);
  if (wanted.empty()) return known;
  std::vector<fs::path> found;
  for (const std::string& each : wanted) {
    const std::size_t before = found.size();
    for (const fs::path& file : known)
      if (means(each, file)) found.push_back(file);
    if (found.size() == before && fs::path(each).extension() == ".yaml") found.emplace_back(each);
    if (found.size() == before)
      throw InputError(fmt::format("--scene {}: {}; --list names them", each, bundled.none_such));
  }
  return found;
}

SceneSetting parse_setting(const std::string& text, bool may_name_scene) {
  const std::size_t equals = text.find('='), colon = may_name_scene ? text.find(':') : std::string::npos;
  const bool names_scene = colon < equals;
  SceneSetting setting;
  if (names_scene) setting.scene = text.substr(0, colon);
  const std::size_t begin = names_scene ? colon + 1 : 0;
  if (equals == std::string::npos || equals == begin || (names_scene && colon == 0))
    throw InputError("--set '" + text + "': expected NAME=VALUE" +
                     (may_name_scene ? " or SCENE:NAME=VALUE" : ""));
  setting.name = text.substr(begin, equals - begin);
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + equals + 1, last, setting.value);
  if (error != std::errc() || end != last || !std::isfinite(setting.value))
    throw InputError("--set '" + text + "': the value is no finite number");
  return setting;
}

std::vector<std::string> choose_backends(const std::vector<std::string>& wanted,
                                         const BackendRegistry& registry) {
  std::vector<std::string> names;
  for (const std::string& name : wanted) {
    if (name != "all")
      names.push_back(registry.narrowphase(name).name);
    else
      for (const auto& entry : registry.narrowphases()) names.push_back(entry.name);
  }
  return names;
}

std::string backend_list(const BackendRegistry& registry) {
  std::string text;
  for (const auto& entry : registry.narrowphases())
    text += fmt::format("  {:26}  {}\n", entry.name, entry.description);
  return text;
}

}  // namespace touchstone::program
