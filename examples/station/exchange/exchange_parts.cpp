#include "touchstone/examples/station/exchange/exchange_parts.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <system_error>

namespace touchstone::station {

Exchange::Exchange(std::size_t frame_bytes) : wake_fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  // Each of the three slots gets its memory here.
  for (int i = 0; i < 3; ++i) {
    frame.back().reserve(frame_bytes);
    frame.publish();
    frame.take();
  }
}

Exchange::~Exchange() { close(wake_fd_); }

void Exchange::wake() const noexcept {
  const std::uint64_t one = 1;
  // Only a full counter can refuse it, and then the reader is awake anyway.
  [[maybe_unused]] const ssize_t written = write(wake_fd_, &one, sizeof(one));
}

double station_us() noexcept {
  static const auto start = std::chrono::steady_clock::now();
  const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - start;
  return passed.count();
}

}  // namespace touchstone::station
