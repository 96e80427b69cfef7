#include "touchstone/adapters/gltf/gltf_buffer.hpp"

#include <algorithm>
#include <bit>
#include <string_view>

namespace touchstone::gltf {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr int kFloat = 5126, kUnsignedInt = 5125;

std::size_t components_of(std::string_view type) { return type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4; }

}  // namespace

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::size_t Buffer::add_view(const void* data, std::size_t bytes, Target target) {
  // Every element is of 4-byte components: views stay aligned.
  const auto* from = static_cast<const std::uint8_t*>(data);
  nlohmann::ordered_json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}};
  if (target != Target::none) view["target"] = static_cast<int>(target);
  bytes_.insert(bytes_.end(), from, from + bytes);
  views_.push_back(std::move(view));
  return views_.size() - 1;
}

std::size_t Buffer::add(std::span<const float> values, const char* type, Target target) {
  const std::size_t components = components_of(type);
  std::vector<float> least(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(components));
  std::vector<float> most = least;
  for (std::size_t i = 0; i < values.size(); ++i) {
    least[i % components] = std::min(least[i % components], values[i]);
    most[i % components] = std::max(most[i % components], values[i]);
  }
  accessors_.push_back({{"bufferView", add_view(values.data(), values.size_bytes(), target)},
                        {"componentType", kFloat},
                        {"count", values.size() / components},
                        {"type", type},
                        {"min", least},
                        {"max", most}});
  return accessors_.size() - 1;
}

std::size_t Buffer::add(std::span<const std::uint32_t> indices) {
  accessors_.push_back({{"bufferView", add_view(indices.data(), indices.size_bytes(), Target::indices)},
                        {"componentType", kUnsignedInt},
                        {"count", indices.size()},
                        {"type", "SCALAR"}});
  return accessors_.size() - 1;
}

void Buffer::write(nlohmann::ordered_json& document) const {
  document["buffers"] = {
      {{"byteLength", bytes_.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes_)}}};
  document["bufferViews"] = views_;
  document["accessors"] = accessors_;
}

}  // namespace touchstone::gltf
