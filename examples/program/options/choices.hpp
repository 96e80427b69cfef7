#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/registry.hpp"

// Options that several programs share.

namespace touchstone::program {

/// The bundled YAML files of a program, numbered by their names.
struct BundledFiles {
  std::filesystem::path folder;
  std::string_view folder_option;  ///< "--scenes"
  std::string_view none_such;      ///< the message for a choice that is neither bundled nor a YAML file
};

/// Those wanted by --scene: a number ("8", "08": every file whose name starts with it), a name without .yaml,
/// or any YAML file's path; all bundled ones, by name, when nothing is wanted.
/// @throws InputError: the folder cannot be read, or nothing is meant by a choice.
std::vector<std::filesystem::path> choose_files(const BundledFiles& bundled,
                                                const std::vector<std::string>& wanted);

/// --set [SCENE:]NAME=VALUE: a parameter of one scene (by its file's stem), or of every scene that has it.
struct SceneSetting {
  std::string scene;  ///< empty: every scene
  std::string name;
  double value = 0;  ///< in the file's units
};

/// @throws InputError for what is no setting. @param may_name_scene else a colon belongs to the name.
SceneSetting parse_setting(const std::string& text, bool may_name_scene);

/// Names of narrowphases; "all" stands for every one. @throws InputError for one that is not there.
std::vector<std::string> choose_backends(const std::vector<std::string>& wanted,
                                         const BackendRegistry& registry);

/// Every narrowphase and what it is, a line each, for --list.
std::string backend_list(const BackendRegistry& registry);

}  // namespace touchstone::program
