#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

// Private to this folder.

namespace touchstone::cigi {

/// A connected UDP socket that never waits.
class UdpSocket {
 public:
  /// @param local_port 0: any.
  /// @throws InputError naming host and port.
  UdpSocket(const std::string& host, std::uint16_t port, std::uint16_t local_port);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  std::uint16_t local_port() const noexcept;
  /// 0, or errno. An error that an earlier datagram left behind (nobody listens) is reported here, and this
  /// datagram is not sent.
  int send(std::span<const std::byte> datagram) noexcept;
  /// Bytes of the next datagram that waits (what does not fit is cut off), or -errno: -EAGAIN with none.
  std::ptrdiff_t receive(std::span<std::byte> datagram) noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace touchstone::cigi
