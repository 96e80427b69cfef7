#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cstddef>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "adapters/cigi/packets.hpp"

// The image generator's side, written apart from the adapter: it reads packets by the tables of the standard.

namespace touchstone {

using Bytes = std::vector<std::byte>;

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

/// A socket on this machine that an image generator would listen at.
class Listener {
 public:
  Listener() : descriptor_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no local socket");
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { close(descriptor_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::uint16_t port() const { return port_; }

  /// The next datagram; none if none comes within a second.
  std::optional<Bytes> receive() {
    pollfd waiting{descriptor_, POLLIN, 0};
    if (poll(&waiting, 1, 1000) != 1) return std::nullopt;
    Bytes bytes(65536);
    socklen_t size = sizeof sender_;
    const ssize_t count =
        recvfrom(descriptor_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&sender_), &size);
    bytes.resize(static_cast<std::size_t>(count));
    return bytes;
  }
  Message receive_message() {
    const auto bytes = receive();
    if (!bytes) throw std::runtime_error("no datagram came");
    return read_message(*bytes);
  }

  /// To whom the last datagram came from.
  void answer(const Bytes& bytes) const {
    sendto(descriptor_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&sender_),
           sizeof sender_);
  }

 private:
  int descriptor_;
  std::uint16_t port_ = 0;
  sockaddr_in sender_{};
};

}  // namespace touchstone
