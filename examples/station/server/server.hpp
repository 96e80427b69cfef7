#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "touchstone/examples/station/exchange/exchange_parts.hpp"
#include "touchstone/examples/station/exchange/recording.hpp"

namespace touchstone::station {

struct ServerSettings {
  std::string bind = "127.0.0.1";     ///< an address; anything but loopback needs a token
  std::uint16_t port = 8090;          ///< 0: any that is free
  std::uint16_t udp_port = 0;         ///< of hands that send datagrams, on the same address; 0: none
  std::string token;                  ///< empty: none is asked for, loopback alone
  std::filesystem::path page;         ///< folder of the page's files
  std::string saved_flight;           ///< /record.tsf, which pages open when they are loaded; empty: none
  std::size_t most_clients = 16;      ///< WebSockets
  std::size_t most_connections = 64;  ///< sockets in all
  std::size_t most_message = 65536;   ///< bytes of a message from a page
};

/// Pilots that are no page; pages count from 1.
inline constexpr std::uint32_t kDatagramClient = 0xffffffff, kSpaceMouseClient = 0xfffffffe,
                               kScriptClient = 0xfffffffd;

/// Counts of the server's work so far. Any thread.
struct ServerFigures {
  std::atomic<std::uint64_t> accepted{0}, refused{0};  ///< sockets; requests that were turned away
  std::atomic<std::uint64_t> clients{0};               ///< now
  std::atomic<std::uint64_t> closed_for_garbage{0};
  std::atomic<std::uint64_t> frames_sent{0}, frames_overwritten{0}, texts_dropped{0};
  std::atomic<std::uint64_t> controls_refused{0};  ///< no room
  std::atomic<std::uint64_t> datagrams{0}, bad_datagrams{0};
  std::atomic<std::uint64_t> most_bytes_waiting{0};  ///< of frames and texts for all clients
};

/// Serves the page and its WebSocket (protocol.md) on a thread of its own.
class Server {
 public:
  /// Keeps references; `recorder` may be null. Listens when it returns.
  /// @throws InputError: an address that is invalid or taken, no page, a bound address beyond loopback
  /// without token.
  Server(const ServerSettings& settings, Exchange& exchange, const StationScenes& scenes, std::size_t scene,
         double rate, const Recorder* recorder);
  ~Server();  ///< closes all sockets

  /// The input of a pilot that is no page; the newest counts, what the server could not take in
  /// time is overwritten. Any thread.
  void fly(std::uint32_t client, std::uint32_t number, const HandInput& hand);

  std::uint16_t port() const;
  std::uint16_t udp_port() const;
  const ServerFigures& figures() const;
  const LatencyFigures& latency() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// 128 random bits, in hexadecimal.
std::string make_token();

}  // namespace touchstone::station
