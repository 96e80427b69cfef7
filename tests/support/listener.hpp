#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

namespace touchstone {

using Bytes = std::vector<std::byte>;

/// A UDP socket of this machine, at a port that nobody else has.
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

  /// The next datagram; none if none comes in this time [ms].
  std::optional<Bytes> receive(int patience = 1000) {
    pollfd waiting{descriptor_, POLLIN, 0};
    if (poll(&waiting, 1, patience) != 1) return std::nullopt;
    Bytes bytes(65536);
    socklen_t size = sizeof sender_;
    const ssize_t count =
        recvfrom(descriptor_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&sender_), &size);
    bytes.resize(static_cast<std::size_t>(count));
    return bytes;
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
