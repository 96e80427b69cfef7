#include "touchstone/adapters/cigi/udp_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::cigi {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

[[noreturn]] void reject(const std::string& host, std::uint16_t port, const std::string& reason) {
  throw InputError("cigi: image generator '" + host + "' port " + std::to_string(port) + ": " + reason);
}

Addresses find_addresses(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found))
    reject(host, port, gai_strerror(error));
  return {found, &freeaddrinfo};
}

bool bind_to(int descriptor, int family, std::uint16_t port) {
  if (port == 0) return true;
  sockaddr_in6 address6{};
  address6.sin6_family = AF_INET6;
  address6.sin6_port = htons(port);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  if (family == AF_INET6)
    return bind(descriptor, reinterpret_cast<const sockaddr*>(&address6), sizeof address6) == 0;
  return bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

}  // namespace

UdpSocket::UdpSocket(const std::string& host, std::uint16_t port, std::uint16_t local_port) {
  const Addresses addresses = find_addresses(host, port);
  int error = 0;
  for (const addrinfo* address = addresses.get(); address != nullptr; address = address->ai_next) {
    descriptor_ = socket(address->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (descriptor_ >= 0 && bind_to(descriptor_, address->ai_family, local_port) &&
        connect(descriptor_, address->ai_addr, address->ai_addrlen) == 0)
      return;
    error = errno;
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = -1;
  }
  reject(host, port, std::strerror(error));
}

UdpSocket::~UdpSocket() { close(descriptor_); }

std::uint16_t UdpSocket::local_port() const noexcept {
  sockaddr_in6 address{};  // sin_port and sin6_port stand at the same place
  socklen_t size = sizeof address;
  if (getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.sin6_port);
}

int UdpSocket::send(std::span<const std::byte> datagram) noexcept {
  while (::send(descriptor_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0)
    if (errno != EINTR) return errno;
  return 0;
}

std::ptrdiff_t UdpSocket::receive(std::span<std::byte> datagram) noexcept {
  const ssize_t count = recv(descriptor_, datagram.data(), datagram.size(), MSG_DONTWAIT);
  return count < 0 ? -errno : count;
}

}  // namespace touchstone::cigi
