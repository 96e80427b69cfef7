#pragma once

#include <array>
#include <string>
#include <vector>

#include "touchstone/examples/station/exchange/exchange.hpp"
#include "touchstone/examples/station/exchange/figures.hpp"
#include "touchstone/examples/station/flight/session.hpp"

namespace touchstone::station {

/// The newest thing that hands hold, and where it came from.
struct HandMessage {
  HandInput hand;
  InputStamp stamp;
};

/// A line for the log on the page; text holds what fits.
struct StationEvent {
  /// Of a pair: EventKind's; else `note`.
  enum class Kind : std::uint8_t {
    near,
    began,
    ended,
    blocked,
    at_limit,
    refused,
    penetrating_at_start,
    latched,
    released,
    reset,
    scene,
    fault,
    note
  } kind = Kind::note;
  std::uint64_t frame = 0;
  double time = 0.0;
  std::uint32_t method = 0;
  bool has_pair = false;
  SolidPair solids{0, 0};
  double separation = 0.0;
  std::array<char, 96> text{};
};

/// The state of the controls, for the page: plain data.
struct StateMessage {
  std::uint64_t frame = 0;
  std::size_t scene = 0;
  std::uint32_t serial = 1;
  FlightState flight;
  FlightFigures figures;
  static constexpr std::size_t kMost = 32;
  std::array<std::array<std::uint32_t, 2>, kMost> latched{};
  std::array<std::uint32_t, kMost> off{};
  std::size_t latched_count = 0, off_count = 0;
  std::array<std::array<std::uint32_t, 2>, 2> held{};  ///< of an arm that walks: tip and fixture
  std::size_t held_count = 0;
  std::array<double, 4> base = {0.0, 0.0, 0.0, 1.0};  ///< attitude of the arm's base: x, y, z, w
  bool changed = true;                                ///< since the last one; else only the figures
};

/// All that the loop and the server hand to each other. The loop never waits for the server.
struct Exchange {
  explicit Exchange(std::size_t frame_bytes);
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  // Server to loop.
  Latest<HandMessage> hand;
  Ring<Control> controls{256};
  // Loop to server.
  Latest<std::vector<std::uint8_t>> frame;
  Ring<StationEvent> events{1024};
  Ring<StateMessage> states{64};
  LoopFigures figures;

  int wake_fd() const { return wake_fd_; }
  /// The loop's: something is there. Never waits.
  void wake() const noexcept;

 private:
  int wake_fd_;
};

/// Microseconds since the program's start; monotonic.
double station_us() noexcept;

}  // namespace touchstone::station
