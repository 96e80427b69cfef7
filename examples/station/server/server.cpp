#include "touchstone/examples/station/server/server.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/finite.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/server/page_client.hpp"
#include "touchstone/examples/station/server/web_files.hpp"

namespace touchstone::station {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;
using udp = asio::ip::udp;
using Request = PageClient::Request;
using Response = http::response<http::string_body>;

constexpr auto kRequestTime = std::chrono::seconds(10);
// Answers this large, records and meshes, are copied: few at a time, and with a second more a MiB to be sent.
constexpr std::size_t kLargeBody = std::size_t{1} << 20, kMostLargeBodies = 2;
constexpr std::uint32_t kMostHeader = 8192, kMostBody = 1024;
constexpr const char* kPolicy =
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; "
    "frame-ancestors 'none'";

/// A datagram of hands; see protocol.md.
constexpr std::uint32_t kDatagramMagic = 0x31555354;  // "TSU1"
constexpr std::size_t kDatagramBytes = 64;

Response answer(const Request& request, http::status status, std::string_view type, std::string body) {
  Response response(status, request.version());
  response.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", kPolicy);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.keep_alive(false);
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

std::string text_of(beast::string_view view) { return std::string(view.data(), view.size()); }

}  // namespace

std::string make_token() {
  std::random_device device;
  std::string out;
  for (int i = 0; i < 4; ++i) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::uint32_t bits = device();
    for (int digit = 0; digit < 8; ++digit, bits >>= 4U) out += kDigits[bits & 0xfU];
  }
  return out;
}

struct Server::State {
  class Connection;

  State(const ServerSettings& given, Exchange& exchange, const StationScenes& scenes, std::size_t scene,
        double rate, const Recorder* given_recorder)
      : settings(given),
        recorder(given_recorder),
        host{settings, exchange, scenes, figures, latency, rate},
        acceptor(context),
        udp_socket(context),
        wake(context, dup(exchange.wake_fd())),
        timer(context) {
    host.state.scene = scene;
  }

  const ServerSettings settings;
  const Recorder* recorder;
  ServerFigures figures;
  LatencyFigures latency;
  ClientHost host;
  std::size_t large_bodies = 0;
  std::size_t connections = 0;  // before the context: what still waits there at the end counts itself out
  asio::io_context context{1};
  tcp::acceptor acceptor;
  udp::socket udp_socket;
  asio::posix::stream_descriptor wake;
  asio::steady_timer timer;
  std::array<std::uint8_t, 2 * kDatagramBytes> datagram{};
  udp::endpoint datagram_from;
  std::mutex flown_mutex;
  std::vector<HandMessage> flown;  // of fly(), the newest of each client; not empty: its taking is posted
  std::thread thread;

  void listen();
  void accept();
  void receive();
  void take_datagram(std::size_t bytes);
  void take_flown();
  void wait_for_loop();
  void take_from_loop();
  void tick();
  bool is_known(const Request& request, const Target& target) const;
  bool is_own_page(const Request& request) const;
  Response respond(const Request& request);
  Response respond_with_file(const Request& request, const Target& target);
  const std::string* meshes_at(std::string_view path) const;
  std::string status_json() const;
  bool upgrade(const Request& request, beast::tcp_stream& stream);
};

/// One request of one socket.
class Server::State::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Server::State& server) : stream_(std::move(socket)), server_(server) {
    ++server_.connections;
  }
  ~Connection() {
    --server_.connections;
    if (is_large_) --server_.large_bodies;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start() {
    parser_.header_limit(kMostHeader);
    parser_.body_limit(kMostBody);
    stream_.expires_after(kRequestTime);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->take();
                     });
  }

 private:
  void take() {
    const Request& request = parser_.get();
    if (beast::websocket::is_upgrade(request) && server_.upgrade(request, stream_)) return;
    response_ = server_.respond(request);
    is_large_ = response_.body().size() > kLargeBody;
    if (is_large_ && ++server_.large_bodies > kMostLargeBodies)
      response_ = answer(request, http::status::service_unavailable, "text/plain; charset=utf-8",
                         "records are being sent: try again\n");
    stream_.expires_after(kRequestTime + std::chrono::seconds(response_.body().size() >> 20));
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  beast::tcp_stream stream_;
  Server::State& server_;
  beast::flat_buffer buffer_{kMostHeader + kMostBody};
  http::request_parser<http::string_body> parser_;
  Response response_;
  bool is_large_ = false;
};

// ---- who is let in

/// With a token: who brings it. Without: who names this machine by itself, which pages of other hosts cannot.
bool Server::State::is_known(const Request& request, const Target& target) const {
  if (!settings.token.empty())
    return is_same_secret(target.token, settings.token) ||
           is_same_secret(token_in_cookies(text_of(request[http::field::cookie])), settings.token);
  return is_loopback_host(text_of(request[http::field::host]), acceptor.local_endpoint().port());
}

bool Server::State::is_own_page(const Request& request) const {
  return text_of(request[http::field::origin]) == "http://" + text_of(request[http::field::host]);
}

bool Server::State::upgrade(const Request& request, beast::tcp_stream& stream) {
  const Target target = split_target(std::string_view(request.target().data(), request.target().size()));
  if (target.path != "/socket" || !is_known(request, target) || !is_own_page(request) ||
      host.clients.size() >= settings.most_clients)
    return false;
  const auto client = std::make_shared<PageClient>(std::move(stream), host);
  host.clients.insert(client);
  figures.clients.store(host.clients.size(), std::memory_order_relaxed);
  client->start(request);
  return true;
}

Response Server::State::respond(const Request& request) {
  const Target target = split_target(std::string_view(request.target().data(), request.target().size()));
  const auto refuse = [&](http::status status, const char* why) {
    figures.refused.fetch_add(1, std::memory_order_relaxed);
    return answer(request, status, "text/plain; charset=utf-8", std::string(why) + "\n");
  };
  // Nothing is let in from elsewhere.
  if (!is_known(request, target))
    return refuse(http::status::forbidden, "not from this machine, or without the token");
  if (target.path == "/socket") {
    if (!beast::websocket::is_upgrade(request)) return refuse(http::status::upgrade_required, "a WebSocket");
    if (!is_own_page(request)) return refuse(http::status::forbidden, "not from the station's own page");
    return refuse(http::status::service_unavailable, "no more clients");
  }
  if (request.method() != http::verb::get) return refuse(http::status::method_not_allowed, "GET alone");
  // Figures and recordings, then the page's files.
  if (target.path == "/latency.json")
    return answer(request, http::status::ok, "application/json",
                  latency_json(latency, host.exchange.figures, host.rate, host.offset_us, host.rtt_us));
  if (target.path == "/status.json")
    return answer(request, http::status::ok, "application/json", status_json());
  if (target.path == "/recording.jsonl" && recorder != nullptr)
    return answer(request, http::status::ok, "application/jsonl", recorder->kept());
  if (target.path == "/record.tsf" && !settings.saved_flight.empty())
    return answer(request, http::status::ok, "application/octet-stream", settings.saved_flight);
  if (const std::string* meshes = meshes_at(target.path))
    return answer(request, http::status::ok, "application/octet-stream", *meshes);
  Response response = respond_with_file(request, target);
  if (!settings.token.empty() && response.result() == http::status::ok)
    response.set(http::field::set_cookie,
                 "station_token=" + settings.token + "; HttpOnly; SameSite=Strict; Path=/");
  return response;
}

Response Server::State::respond_with_file(const Request& request, const Target& target) {
  const auto file = file_below(settings.page, target.path == "/" ? "/index.html" : target.path);
  std::optional<std::string> text = file ? read_file(*file) : std::nullopt;
  if (!text) return answer(request, http::status::not_found, "text/plain; charset=utf-8", "no such file\n");
  return answer(request, http::status::ok, content_type(file->native()), std::move(*text));
}

/// Null: no scene has meshes there.
const std::string* Server::State::meshes_at(std::string_view path) const {
  for (const auto& scene : host.scenes)
    if (!scene->meshes.bytes.empty() && path == "/" + scene->meshes.path) return &scene->meshes.bytes;
  return nullptr;
}

std::string Server::State::status_json() const {
  const LoopFigures& loop = host.exchange.figures;
  return nlohmann::json{{"frame", loop.frame.load()},
                        {"missed", loop.missed.load()},
                        {"median_step_us", loop.step.quantile_us(0.5)},
                        {"p999_step_us", loop.step.quantile_us(0.999)},
                        {"worst_step_us", loop.step.worst_us()},
                        {"allocations_in_steps", loop.allocations.load()},
                        {"not_judged", loop.not_judged.load()},
                        {"not_recorded", loop.not_recorded.load()},
                        {"events_lost", loop.events_lost.load()},
                        {"clients", figures.clients.load()},
                        {"connections", connections},
                        {"accepted", figures.accepted.load()},
                        {"refused", figures.refused.load()},
                        {"closed_for_garbage", figures.closed_for_garbage.load()},
                        {"frames_sent", figures.frames_sent.load()},
                        {"frames_overwritten", figures.frames_overwritten.load()},
                        {"texts_dropped", figures.texts_dropped.load()},
                        {"controls_refused", figures.controls_refused.load()},
                        {"datagrams", figures.datagrams.load()},
                        {"bad_datagrams", figures.bad_datagrams.load()},
                        {"most_bytes_waiting", figures.most_bytes_waiting.load()}}
      .dump();
}

// ---- sockets

void Server::State::listen() {
  beast::error_code error;
  const asio::ip::address address = asio::ip::make_address(settings.bind, error);
  if (error) throw InputError("'" + settings.bind + "' is no address");
  if (!address.is_loopback() && settings.token.empty())
    throw InputError("bound beyond loopback, the station needs a token");
  if (!address.is_loopback() && settings.udp_port != 0)
    throw InputError("datagrams of hands bring no token: no --udp with a --bind beyond loopback");
  const tcp::endpoint endpoint(address, settings.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw InputError(settings.bind + ":" + std::to_string(settings.port) + ": " + error.message() +
                     (error == asio::error::address_in_use ? "; --port 0 takes a free one" : ""));
  if (settings.udp_port == 0) return;
  const udp::endpoint datagrams(address, settings.udp_port);
  udp_socket.open(datagrams.protocol(), error);
  if (!error) udp_socket.bind(datagrams, error);
  if (error)
    throw InputError("UDP " + settings.bind + ":" + std::to_string(settings.udp_port) + ": " +
                     error.message());
}

void Server::State::accept() {
  acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      figures.accepted.fetch_add(1, std::memory_order_relaxed);
      // A client too many is closed by its destructor, at once.
      if (connections + host.clients.size() < settings.most_connections)
        std::make_shared<Connection>(std::move(socket), *this)->start();
    }
    accept();
  });
}

void Server::State::receive() {
  udp_socket.async_receive_from(asio::buffer(datagram), datagram_from,
                                [this](beast::error_code error, std::size_t bytes) {
                                  if (error == asio::error::operation_aborted) return;
                                  if (!error) take_datagram(bytes);
                                  receive();
                                });
}

void Server::State::take_datagram(std::size_t bytes) {
  std::uint32_t magic = 0;
  HandMessage message;
  std::array<double, 7> axes{};
  if (bytes == kDatagramBytes) {
    std::memcpy(&magic, datagram.data(), sizeof(magic));
    std::memcpy(&message.stamp.number, datagram.data() + 4, sizeof(std::uint32_t));
    std::memcpy(axes.data(), datagram.data() + 8, sizeof(axes));
  }
  if (magic != kDatagramMagic || !all_finite(axes)) {
    figures.bad_datagrams.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  figures.datagrams.fetch_add(1, std::memory_order_relaxed);
  message.hand = {{axes[0], axes[1], axes[2]}, {axes[3], axes[4], axes[5]}, axes[6]};
  message.stamp.client = kDatagramClient;
  message.stamp.browser_us = kNaN;
  message.stamp.received_us = station_us();
  host.take_hand(kDatagramClient, message);
}

void Server::State::take_flown() {
  std::vector<HandMessage> newest;
  {
    const std::lock_guard lock(flown_mutex);
    newest.swap(flown);
  }
  for (const HandMessage& message : newest) host.take_hand(message.stamp.client, message);
}

// ---- the loop's side

void Server::State::wait_for_loop() {
  wake.async_wait(asio::posix::stream_descriptor::wait_read, [this](beast::error_code error) {
    if (error) return;
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = read(wake.native_handle(), &count, sizeof(count));
    take_from_loop();
    wait_for_loop();
  });
}

void Server::State::take_from_loop() {
  Exchange& exchange = host.exchange;
  while (const StateMessage* state = exchange.states.front()) {
    host.take_state(*state);
    exchange.states.pop();
  }
  while (const StationEvent* event = exchange.events.front()) {
    host.take_event(*event);
    exchange.events.pop();
  }
  if (exchange.frame.take()) {
    host.frame = exchange.frame.front();
    ++host.frame_serial;
  }
  std::size_t waiting = 0;
  for (const auto& client : host.clients) {
    client->pump();
    waiting += client->bytes_waiting();
  }
  if (waiting > figures.most_bytes_waiting.load(std::memory_order_relaxed))
    figures.most_bytes_waiting.store(waiting, std::memory_order_relaxed);
}

void Server::State::tick() {
  timer.expires_after(std::chrono::seconds(1));
  timer.async_wait([this](beast::error_code error) {
    if (error) return;
    if (!host.clients.empty())
      host.tell_all(latency_json(latency, host.exchange.figures, host.rate, host.offset_us, host.rtt_us),
                    Text::latency);
    tick();
  });
}

Server::Server(const ServerSettings& settings, Exchange& exchange, const StationScenes& scenes,
               std::size_t scene, double rate, const Recorder* recorder)
    : state_(std::make_unique<State>(settings, exchange, scenes, scene, rate, recorder)) {
  State& state = *state_;
  state.listen();
  state.accept();
  if (settings.udp_port != 0) state.receive();
  state.wait_for_loop();
  state.tick();
  state.thread = std::thread([&state] { state.context.run(); });
}

Server::~Server() {
  asio::post(state_->context, [state = state_.get()] {
    beast::error_code ignored;
    state->acceptor.close(ignored);
    state->udp_socket.close(ignored);
    state->wake.cancel(ignored);
    state->timer.cancel();
    const auto clients = state->host.clients;
    for (const auto& client : clients) client->cut();
  });
  // Connections that wait for a request would hold it up until their time is over.
  asio::post(state_->context,
             [state = state_.get()] { asio::post(state->context, [state] { state->context.stop(); }); });
  state_->thread.join();
  state_->host.clients.clear();
}

void Server::fly(std::uint32_t client, std::uint32_t number, const HandInput& hand) {
  const HandMessage message{hand, {client, number, kNaN, station_us()}};
  {
    const std::lock_guard lock(state_->flown_mutex);
    std::vector<HandMessage>& flown = state_->flown;
    const auto earlier = std::find_if(flown.begin(), flown.end(),
                                      [&](const HandMessage& each) { return each.stamp.client == client; });
    if (earlier != flown.end()) {
      *earlier = message;
      return;
    }
    flown.push_back(message);
    if (flown.size() > 1) return;
  }
  asio::post(state_->context, [state = state_.get()] { state->take_flown(); });
}

std::uint16_t Server::port() const { return state_->acceptor.local_endpoint().port(); }
std::uint16_t Server::udp_port() const { return state_->settings.udp_port; }
const ServerFigures& Server::figures() const { return state_->figures; }
const LatencyFigures& Server::latency() const { return state_->latency; }

}  // namespace touchstone::station
