#pragma once

#include <array>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "touchstone/examples/station/exchange/exchange_parts.hpp"

namespace touchstone::station {

/// A page's message, read and checked; see protocol.md.
struct InputMessage {
  HandInput hand;
  std::uint32_t number = 0;
  double stamp = 0.0;  ///< browser's clock [us]
};
struct ControlMessage {
  std::vector<Control> controls;
  bool debrief = false;
  std::optional<std::pair<std::uint32_t, bool>> camera;  ///< a fault of a camera: of pictures alone
};
struct PingMessage {
  double stamp = 0.0;
};
struct SeenMessage {
  std::uint64_t frame = 0;
};
struct DrawnMessage {
  std::uint64_t frame = 0;
  double stamp = 0.0, offset = 0.0, rtt = 0.0;  ///< [us]
};
/// A message that is not understood; the socket stays open.
struct RefusedMessage {
  std::string text;
};
/// No JSON object: the socket closes.
struct GarbageMessage {};
using PageMessage = std::variant<InputMessage, ControlMessage, PingMessage, SeenMessage, DrawnMessage,
                                 RefusedMessage, GarbageMessage>;

/// Never throws for what is in the text.
PageMessage read_message(std::string_view text, const StationScenes& scenes);

std::string hello_json(const StationScenes& scenes, std::size_t scene, std::uint32_t client, double rate,
                       std::size_t most_clients, std::size_t most_bytes, bool has_record);
std::string scene_json(const StationScene& scene, std::uint32_t serial);
std::string event_json(const StationEvent& event);
/// @param failed_cameras a bit a camera.
std::string state_json(const StateMessage& state, const StationScenes& scenes, std::uint32_t pilot,
                       std::uint32_t failed_cameras = 0);
std::string score_json(const StateMessage& state, const StationScenes& scenes);
/// @param path times and places of the flown frame since the reset. @param events texts of event_json().
std::string debrief_json(const StateMessage& state, const StationScenes& scenes,
                         std::span<const std::array<double, 4>> path, const std::deque<std::string>& events);
std::string pong_json(double stamp, double received_us, double sent_us);
std::string error_json(std::string_view text);
std::string latency_json(const LatencyFigures& latency, const LoopFigures& loop, double rate,
                         double offset_us, double rtt_us);

}  // namespace touchstone::station
