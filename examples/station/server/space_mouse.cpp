#include "touchstone/examples/station/server/space_mouse.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>

namespace touchstone::station {
namespace {

constexpr int kPatience = 100;  // between two looks for its end, and two messages of what is held [ms]

/// -1: nobody listens there.
int connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    errno = ENAMETOOLONG;
    return -1;
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return -1;
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0)  // NOLINT
    return descriptor;
  const int why = errno;
  close(descriptor);
  errno = why;
  return -1;
}

double axis(std::int32_t counts) { return std::clamp(counts / SpaceMouse::kFull, -1.0, 1.0); }

}  // namespace

bool take_space_event(const SpaceEvent& event, HandInput& hand) {
  if (event[0] != 0) return false;
  // Its axes: right, up, towards the pilot. The hand's: forward, left, up.
  hand.translation = {-axis(event[3]), -axis(event[1]), axis(event[2])};
  hand.rotation = {-axis(event[6]), -axis(event[4]), axis(event[5])};
  return true;
}

SpaceMouse::SpaceMouse(Server& server, std::filesystem::path socket) {
  if (socket.empty()) {
    const char* const given = std::getenv("SPNAV_SOCKET");  // NOLINT(concurrency-mt-unsafe)
    socket = given != nullptr && *given != '\0' ? given : "/var/run/spnav.sock";
  }
  descriptor_ = connect_to(socket.string());
  text_ = is_there() ? "SpaceMouse: by spacenav at " + socket.string()
                     : "no SpaceMouse: spacenav's " + socket.string() + ": " + std::strerror(errno);
  if (is_there()) thread_ = std::thread([this, &server] { read(server); });
}

SpaceMouse::~SpaceMouse() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  if (descriptor_ >= 0) close(descriptor_);
}

void SpaceMouse::read(Server& server) {
  using Clock = std::chrono::steady_clock;
  HandInput hand;
  Clock::time_point heard = Clock::now();  // of the last motion
  SpaceEvent event{};
  std::size_t got = 0;  // bytes of it: the stream may split it
  std::uint32_t number = 0;
  while (!stop_) {
    pollfd wait{descriptor_, POLLIN, 0};
    const int ready = poll(&wait, 1, kPatience);
    bool has_moved = false;
    if (ready > 0) {
      const ssize_t more = ::read(descriptor_, reinterpret_cast<char*>(event.data()) + got,  // NOLINT
                                  sizeof(event) - got);
      if (more <= 0) break;  // the daemon has ended
      got += static_cast<std::size_t>(more);
      if (got == sizeof(event)) {
        got = 0;
        has_moved = take_space_event(event, hand);
      }
    }
    if (has_moved) heard = Clock::now();
    const bool holds = !(hand == HandInput{});
    const bool is_lost = holds && Clock::now() - heard > kMostSilence;
    if (is_lost) hand = {};
    // A pilot who holds something still is heard of, so that it does not count as let go.
    if (has_moved || is_lost || (ready <= 0 && holds)) server.fly(kSpaceMouseClient, ++number, hand);
  }
  server.fly(kSpaceMouseClient, ++number, {});
}

}  // namespace touchstone::station
