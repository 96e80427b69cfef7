#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>

#include "touchstone/examples/station/server/server.hpp"

namespace touchstone::station {

/// The messages of spacenav's daemon: eight words an event. Of a motion: 0, then x y z (right, up, towards
/// the pilot), the turns about these, and the milliseconds since the last one.
using SpaceEvent = std::array<std::int32_t, 8>;

/// Adds an event to what the hand holds: forward, left and up are the hand's x, y and z. False: a button's,
/// or none, which change nothing.
bool take_space_event(const SpaceEvent& event, HandInput& hand);

/// Flies a station by a SpaceMouse, through the socket of spacenav's daemon, on a thread of its own. The
/// daemon's first protocol is spoken, which needs no library. What is held is let go when the daemon ends, or
/// says nothing for kMostSilence: a device that was unplugged sends no zero.
class SpaceMouse {
 public:
  /// Keeps a reference. Looks for the daemon once.
  /// @param socket the daemon's; empty: SPNAV_SOCKET's, else /var/run/spnav.sock.
  SpaceMouse(Server& server, std::filesystem::path socket);
  ~SpaceMouse();
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  bool is_there() const { return descriptor_ >= 0; }
  /// One line: where it was found, or why not.
  const std::string& text() const { return text_; }

  /// Counts of full deflection; what a daemon at its usual sensitivity sends at most.
  static constexpr double kFull = 350.0;
  /// A hand that holds a device is never quite still; assumed.
  static constexpr std::chrono::seconds kMostSilence{2};

 private:
  void read(Server& server);

  int descriptor_ = -1;
  std::string text_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace touchstone::station
