#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

// Private to this folder.

namespace touchstone::gltf {

std::string base64(std::span<const std::uint8_t> bytes);

/// A glTF file's one buffer, with its views and accessors.
class Buffer {
 public:
  enum class Target : int { none = 0, vertices = 34962, indices = 34963 };

  /// @param type SCALAR, VEC3 or VEC4. @return the accessor's index.
  std::size_t add(std::span<const float> values, const char* type, Target target = Target::none);
  std::size_t add(std::span<const std::uint32_t> indices);

  /// Into `document`: buffers, bufferViews, accessors.
  void write(nlohmann::ordered_json& document) const;

 private:
  std::size_t add_view(const void* data, std::size_t bytes, Target target);

  std::vector<std::uint8_t> bytes_;
  nlohmann::ordered_json views_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json accessors_ = nlohmann::ordered_json::array();
};

}  // namespace touchstone::gltf
