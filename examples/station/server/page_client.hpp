#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "touchstone/examples/station/messages/messages.hpp"
#include "touchstone/examples/station/server/server.hpp"

namespace touchstone::station {

class PageClient;

/// The subject of a text to a page. Events, answers and the like are all sent; of the others only the newest.
enum class Text : std::uint8_t { passing, hello, scene, state, score, latency, debrief };

/// State that all clients of the page share. Of the server's thread only.
struct ClientHost {
  const ServerSettings& settings;
  Exchange& exchange;
  const StationScenes& scenes;
  ServerFigures& figures;
  LatencyFigures& latency;
  double rate;
  std::span<const std::uint8_t> frame = {};  ///< the newest
  std::uint64_t frame_serial = 0;            ///< frames taken from the loop so far
  StateMessage state = {};
  std::set<std::shared_ptr<PageClient>> clients = {};
  std::uint32_t next_client = 1;
  std::uint32_t pilot = 0;  ///< whose hand it is; 0: nobody's
  HandMessage pilot_hand = {};
  double offset_us = 0.0, rtt_us = 0.0;  ///< as the last page reported
  std::uint32_t failed_cameras = 0;      ///< a bit a camera
  /// For the debrief: since the last reset, at most kMostPath and kMostLogged of them.
  std::vector<std::array<double, 4>> path = {};
  std::deque<std::string> log = {};
  static constexpr std::size_t kMostPath = 9000, kMostLogged = 200;

  void take_state(const StateMessage& given);
  void take_event(const StationEvent& event);
  /// A hand's message. Who holds something takes over from a pilot who holds nothing, or has gone; nothing
  /// held by others is passed by.
  void take_hand(std::uint32_t client, const HandMessage& message);
  void tell_all(const std::string& text, Text about);
  void tell_state();
};

/// One WebSocket. Holds at most one frame, kMostTexts passing texts and one of each other kind on
/// their way out, whatever the other end does.
class PageClient : public std::enable_shared_from_this<PageClient> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  PageClient(boost::beast::tcp_stream&& stream, ClientHost& host);

  void start(const Request& request);
  /// If there is no room the oldest `passing` text is dropped; of the others the newest of a kind waits.
  void tell(std::shared_ptr<const std::string> text, Text about = Text::passing);
  /// Sends what waits, if nothing is on its way: texts first, then the newest frame.
  void pump();
  void close(boost::beast::websocket::close_code code);
  /// At once, without a word.
  void cut();
  std::uint32_t id() const { return id_; }
  std::size_t bytes_waiting() const;

  static constexpr std::size_t kMostTexts = 64;

 private:
  /// A frame that was handed to the socket, for the account of its latency.
  struct Sent {
    std::uint64_t frame = 0;
    InputStamp input;
    double started_us = 0.0, decided_us = 0.0, sent_us = 0.0;
  };

  void set_options(const Request& request);
  void greet();
  void read();
  void take(std::string_view text);
  void take(const InputMessage& message, double now);
  void take(const ControlMessage& message);
  void take(const SeenMessage& message);
  void take(const DrawnMessage& message);
  bool is_flooding(std::size_t bytes);
  bool may_send_frame() const;
  void send_text();
  void send_frame();
  void note_sent();
  void leave();

  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  ClientHost& host_;
  std::uint32_t id_;
  boost::beast::flat_buffer buffer_;
  struct Waiting {
    std::shared_ptr<const std::string> text;
    Text about;
  };
  std::deque<Waiting> texts_;
  std::vector<std::uint8_t> frame_;  // on its way
  bool is_open_ = false, is_writing_ = false, is_closing_ = false;
  std::uint64_t sent_serial_ = 0, sent_frame_ = 0, overwritten_ = 0;
  bool reports_seen_ = false;
  std::uint64_t frames_sent_ = 0, frames_seen_ = 0;
  std::uint64_t first_unseen_ = 0;  // the last that was sent while no other was on its way
  double first_took_us_ = 0.0;      // from sent to seen, of the last such one that was seen
  double rtt_us_ = 0.0;             // as its clock bounds it
  std::array<Sent, 64> sent_{};     // by frames_sent_
  std::uint32_t drawn_input_ = 0;
  double budget_since_us_ = 0.0;
  std::size_t budget_messages_ = 0, budget_bytes_ = 0;
};

}  // namespace touchstone::station
