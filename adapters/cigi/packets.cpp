#include "touchstone/adapters/cigi/packets.hpp"

#include <algorithm>
#include <bit>

namespace touchstone::cigi {
namespace {

constexpr std::uint8_t kIgControl = 1, kEntityControl = 2, kStartOfFrame = 101;  // packet identifiers
constexpr std::uint8_t kMajorVersion = 3, kMinorVersion = 3;
constexpr std::uint16_t kByteSwap = 0x8000;

constexpr std::uint8_t bits(bool value, int shift) {
  return static_cast<std::uint8_t>(value ? 1 << shift : 0);
}

template <class Word>
void put(std::span<std::byte> out, std::size_t at, Word value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    out[at + i] = static_cast<std::byte>((value >> (8 * (sizeof value - 1 - i))) & 0xff);
}

void put(std::span<std::byte> out, std::size_t at, float value) {
  put(out, at, std::bit_cast<std::uint32_t>(value));
}
void put(std::span<std::byte> out, std::size_t at, double value) {
  put(out, at, std::bit_cast<std::uint64_t>(value));
}

std::uint8_t byte_at(std::span<const std::byte> in, std::size_t at) {
  return std::to_integer<std::uint8_t>(in[at]);
}

std::uint32_t word_at(std::span<const std::byte> in, std::size_t at, bool is_big_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | byte_at(in, at + (is_big_endian ? i : 3 - i));
  return value;
}

}  // namespace

void encode(const IgControl& packet, std::span<std::byte, kIgControlBytes> out) noexcept {
  std::fill(out.begin(), out.end(), std::byte{0});
  put(out, 0, kIgControl);
  put(out, 1, static_cast<std::uint8_t>(kIgControlBytes));
  put(out, 2, kMajorVersion);
  put(out, 3, static_cast<std::uint8_t>(packet.database));
  put(out, 4,
      static_cast<std::uint8_t>(static_cast<std::uint8_t>(packet.mode) | bits(packet.is_timestamp_valid, 2) |
                                bits(packet.extrapolates, 3) | kMinorVersion << 4));
  put(out, 6, kByteSwap);
  put(out, 8, packet.host_frame);
  put(out, 12, packet.timestamp);
  put(out, 16, packet.last_ig_frame);
}

void encode(const EntityControl& packet, std::span<std::byte, kEntityControlBytes> out) noexcept {
  std::fill(out.begin(), out.end(), std::byte{0});
  put(out, 0, kEntityControl);
  put(out, 1, static_cast<std::uint8_t>(kEntityControlBytes));
  put(out, 2, packet.id);
  put(out, 4,
      static_cast<std::uint8_t>(static_cast<std::uint8_t>(packet.state) | bits(packet.is_attached, 2)));
  put(out, 6, packet.alpha);
  put(out, 8, packet.type);
  put(out, 10, packet.parent);
  put(out, 12, packet.roll);
  put(out, 16, packet.pitch);
  put(out, 20, packet.yaw);
  for (std::size_t i = 0; i < 3; ++i) put(out, 24 + 8 * i, packet.position[i]);
}

std::optional<StartOfFrame> decode_start_of_frame(std::span<const std::byte> message) noexcept {
  if (message.size() < kStartOfFrameBytes || byte_at(message, 0) != kStartOfFrame ||
      byte_at(message, 1) != kStartOfFrameBytes || byte_at(message, 2) != kMajorVersion)
    return std::nullopt;
  const bool is_big_endian = byte_at(message, 6) == 0x80 && byte_at(message, 7) == 0;
  if (!is_big_endian && !(byte_at(message, 6) == 0 && byte_at(message, 7) == 0x80)) return std::nullopt;
  const std::uint8_t flags = byte_at(message, 5);
  StartOfFrame packet;
  packet.minor_version = flags >> 4;
  if (packet.minor_version < 2) return std::nullopt;  // laid out otherwise
  packet.database = static_cast<std::int8_t>(byte_at(message, 3));
  packet.status = byte_at(message, 4);
  packet.mode = static_cast<IgMode>(flags & 3);
  packet.is_timestamp_valid = (flags & 4) != 0;
  packet.has_own_earth_model = (flags & 8) != 0;
  packet.ig_frame = word_at(message, 8, is_big_endian);
  packet.timestamp = word_at(message, 12, is_big_endian);
  packet.last_host_frame = word_at(message, 16, is_big_endian);
  return packet;
}

}  // namespace touchstone::cigi
