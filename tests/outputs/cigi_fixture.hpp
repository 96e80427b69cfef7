#pragma once

#include <bit>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "touchstone/adapters/cigi/packets.hpp"
#include "touchstone/tests/support/listener.hpp"

// The image generator's side, written apart from the adapter: it reads packets by the tables of the standard.

namespace touchstone {

inline std::uint64_t big_endian(std::span<const std::byte> in, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | std::to_integer<std::uint64_t>(in[at + i]);
  return value;
}

inline cigi::IgControl read_ig_control(std::span<const std::byte> in) {
  const auto flags = big_endian(in, 4, 1);
  return {static_cast<std::int8_t>(big_endian(in, 3, 1)),
          static_cast<cigi::IgMode>(flags & 3),
          (flags & 4) != 0,
          (flags & 8) != 0,
          static_cast<std::uint32_t>(big_endian(in, 8, 4)),
          static_cast<std::uint32_t>(big_endian(in, 12, 4)),
          static_cast<std::uint32_t>(big_endian(in, 16, 4))};
}

inline cigi::EntityControl read_entity_control(std::span<const std::byte> in) {
  const auto real = [&](std::size_t at) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(big_endian(in, at, 4)));
  };
  const auto flags = big_endian(in, 4, 1);
  cigi::EntityControl packet;
  packet.id = static_cast<std::uint16_t>(big_endian(in, 2, 2));
  packet.state = static_cast<cigi::EntityState>(flags & 3);
  packet.is_attached = (flags & 4) != 0;
  packet.alpha = static_cast<std::uint8_t>(big_endian(in, 6, 1));
  packet.type = static_cast<std::uint16_t>(big_endian(in, 8, 2));
  packet.parent = static_cast<std::uint16_t>(big_endian(in, 10, 2));
  packet.roll = real(12), packet.pitch = real(16), packet.yaw = real(20);
  for (std::size_t i = 0; i < 3; ++i)
    packet.position[i] = std::bit_cast<double>(big_endian(in, 24 + 8 * i, 8));
  return packet;
}

struct Message {
  cigi::IgControl control;
  std::vector<cigi::EntityControl> entities;
};

/// @throws std::runtime_error on anything but one IG Control packet and then Entity Control packets.
inline Message read_message(std::span<const std::byte> in) {
  const auto is = [&](std::size_t at, unsigned id, std::size_t size) {
    return at + size <= in.size() && big_endian(in, at, 1) == id && big_endian(in, at + 1, 1) == size;
  };
  if (!is(0, 1, 24) || big_endian(in, 2, 1) != 3 || big_endian(in, 4, 1) >> 4 != 3 ||
      big_endian(in, 6, 2) != 0x8000)
    throw std::runtime_error("no IG Control packet of version 3.3");
  Message message{read_ig_control(in), {}};
  for (std::size_t at = 24; at < in.size(); at += 48) {
    if (!is(at, 2, 48)) throw std::runtime_error("no Entity Control packet");
    message.entities.push_back(read_entity_control(in.subspan(at, 48)));
  }
  return message;
}

inline Message receive_message(Listener& listener) {
  const auto bytes = listener.receive();
  if (!bytes) throw std::runtime_error("no datagram came");
  return read_message(*bytes);
}

}  // namespace touchstone
