#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"
#include "touchstone/contact_core/input_error.hpp"

// Private to this folder: it shows yaml-cpp.

namespace touchstone::scene_files {

/// Data that all nodes of one file share.
struct YamlSource {
  std::string file;
  std::map<std::string, double> parameters;  ///< in the file's units
  double lengths_per_metre = 1.0;
  double radians_per_angle = 1.0;
  ArmModels arm_models = {};  ///< empty: bundled arms
};

/// A file's one YAML document.
/// @throws InputError `file:line: reason`: unreadable or malformed, or more than one document.
YAML::Node parse_yaml(const std::filesystem::path& path);

/// A node that knows where it is: every error reads `file:line: object 'x': hexahedron 'y': reason`.
class YamlReader {
 public:
  YamlReader(const YAML::Node& node, const YamlSource& source, std::string where = {})
      : node_(node), source_(&source), where_(std::move(where)) {}

  /// The same node, its errors prefixed by `what` as well.
  YamlReader within(const std::string& what) const { return {node_, *source_, where_ + what + ": "}; }
  /// The same node, its errors without the prefix: for errors that name the object themselves.
  YamlReader bare() const { return {node_, *source_}; }
  [[noreturn]] void fail(const std::string& reason) const;
  /// Runs `f`; an InputError of it becomes this node's, as fail().
  template <class F>
  auto located(F&& f) const {
    try {
      return f();
    } catch (const InputError& error) {
      fail(error.what());
    }
  }
  std::string file_and_line() const;

  /// A map with no key twice and none but these.
  void require_keys(std::initializer_list<std::string_view> known) const;
  bool has(std::string_view key) const;
  YamlReader at(std::string_view key) const;
  std::vector<YamlReader> list() const;

  std::string text() const;
  double number() const;
  double length() const { return number() / source_->lengths_per_metre; }
  double angle() const { return number() * source_->radians_per_angle; }
  int integer() const;
  std::vector<double> numbers(std::size_t count) const;
  Vector3 vector3() const;
  Vector3 length3() const { return vector3() / source_->lengths_per_metre; }

  const YAML::Node& node() const { return node_; }
  const YamlSource& source() const { return *source_; }

 private:
  double parameter(std::string_view name) const;

  YAML::Node node_;
  const YamlSource* source_;
  std::string where_;
};

}  // namespace touchstone::scene_files
