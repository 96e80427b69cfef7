#include "touchstone/examples/station/server/page_client.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <cmath>
#include <cstring>

#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/server/loop.hpp"

namespace touchstone::station {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr const char* kSubprotocol = "touchstone-station-1";
/// A page that says which frames it has seen gets the next one then. Two on their way would each wait for a
/// turn of a busy page, which takes one in each: the second would be a turn older than it must. Only where
/// the first waits for longer than this and than three quarters of what the last such one took, a second
/// follows it: a page with few turns takes both in the next, and shows the newer [us].
constexpr double kLongUnseen = 100e3;
/// From such a round trip on it is the way that takes the time, not the page: a second frame sets out when
/// the first arrives, by half of it [us]. A step of the default 50 Hz.
constexpr double kFar = 20e3;
/// A page sends a hundred messages a second: what is beyond these is a flood.
constexpr std::size_t kMostMessagesASecond = 2000, kMostBytesASecond = std::size_t{4} << 20U;
/// Most that the kernel may hold for a client that is slow to read: newer frames are worth more [bytes].
constexpr int kSendBuffer = 64 << 10;

template <class T>
T value_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  T out;
  std::memcpy(&out, bytes.data() + at, sizeof(T));
  return out;
}

bool holds_nothing(const HandInput& hand) { return hand == HandInput{}; }

}  // namespace

void ClientHost::take_hand(std::uint32_t client, const HandMessage& message) {
  const bool pilot_is_idle = pilot == 0 || holds_nothing(pilot_hand.hand) ||
                             message.stamp.received_us - pilot_hand.stamp.received_us > kLetGoAfter;
  if (client != pilot && (!pilot_is_idle || (holds_nothing(message.hand) && pilot != 0))) return;
  const bool changed = pilot != client;
  pilot = client;
  pilot_hand = message;
  exchange.hand.back() = message;
  exchange.hand.publish();
  if (changed) tell_state();
}

void ClientHost::tell_all(const std::string& text, Text about) {
  const auto shared = std::make_shared<const std::string>(text);
  for (const auto& client : clients) client->tell(shared, about);
}

void ClientHost::tell_state() { tell_all(state_json(state, scenes, pilot, failed_cameras), Text::state); }

void ClientHost::take_state(const StateMessage& given) {
  const bool is_other_scene = given.serial != state.serial,
             begins_anew = given.figures.time < state.figures.time;
  const bool is_whole_second = std::floor(given.figures.time) != std::floor(state.figures.time);
  state = given;
  if (is_other_scene || begins_anew) {
    path.clear();
    log.clear();
  }
  if (path.size() < kMostPath)
    path.push_back({state.figures.time, state.figures.tip.x(), state.figures.tip.y(), state.figures.tip.z()});
  if (is_other_scene) tell_all(scene_json(*scenes[state.scene], state.serial), Text::scene);
  if (state.changed) tell_state();
  if (is_whole_second && !clients.empty()) tell_all(score_json(state, scenes), Text::score);
}

void ClientHost::take_event(const StationEvent& event) {
  log.push_back(event_json(event));
  if (log.size() > kMostLogged) log.pop_front();
  tell_all(log.back(), Text::passing);
}

PageClient::PageClient(beast::tcp_stream&& stream, ClientHost& host)
    : socket_(std::move(stream)), host_(host), id_(host.next_client++) {}

void PageClient::set_options(const Request& request) {
  beast::get_lowest_layer(socket_).expires_never();
  boost::system::error_code ignored;
  auto& tcp = beast::get_lowest_layer(socket_).socket();
  tcp.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  tcp.set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  websocket::stream_base::timeout timeout;
  timeout.handshake_timeout = std::chrono::seconds(10);
  timeout.idle_timeout = std::chrono::seconds(20);
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  const auto offered = request[http::field::sec_websocket_protocol];
  const bool knows_us = offered.find(kSubprotocol) != beast::string_view::npos;
  socket_.set_option(websocket::stream_base::decorator([knows_us](websocket::response_type& response) {
    if (knows_us) response.set(http::field::sec_websocket_protocol, kSubprotocol);
  }));
  socket_.read_message_max(host_.settings.most_message);
  socket_.auto_fragment(false);
}

void PageClient::start(const Request& request) {
  set_options(request);
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) return self->leave();
    self->greet();
  });
}

void PageClient::greet() {
  is_open_ = true;
  frame_.reserve(host_.frame.size());
  const StateMessage& state = host_.state;
  const auto say = [this](std::string text, Text about) {
    tell(std::make_shared<const std::string>(std::move(text)), about);
  };
  say(hello_json(host_.scenes, state.scene, id_, host_.rate, host_.settings.most_clients,
                 host_.settings.most_message, !host_.settings.saved_flight.empty()),
      Text::hello);
  say(scene_json(*host_.scenes[state.scene], state.serial), Text::scene);
  say(state_json(state, host_.scenes, host_.pilot, host_.failed_cameras), Text::state);
  read();
}

void PageClient::leave() {
  is_open_ = false;
  if (host_.pilot == id_) {
    HandMessage nothing;
    nothing.stamp.received_us = station_us();
    host_.take_hand(id_, nothing);
    host_.pilot = 0;
  }
  host_.clients.erase(shared_from_this());
  host_.figures.clients.store(host_.clients.size(), std::memory_order_relaxed);
}

void PageClient::cut() {
  boost::system::error_code ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
}

void PageClient::close(websocket::close_code code) {
  if (is_closing_) return;
  is_closing_ = true;
  texts_.clear();
  socket_.async_close(code, [self = shared_from_this()](beast::error_code) { self->leave(); });
}

// ---- in

void PageClient::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error) {
      if (error == websocket::error::message_too_big || error == websocket::error::bad_frame_payload)
        self->host_.figures.closed_for_garbage.fetch_add(1, std::memory_order_relaxed);
      return self->leave();
    }
    const auto bytes = self->buffer_.cdata();
    if (self->is_flooding(bytes.size()))
      self->close(websocket::close_code::policy_error);
    else if (!self->socket_.got_text())
      self->close(websocket::close_code::unknown_data);
    else
      self->take(std::string_view(static_cast<const char*>(bytes.data()), bytes.size()));
    self->buffer_.consume(bytes.size());
    if (self->is_closing_)
      self->host_.figures.closed_for_garbage.fetch_add(1, std::memory_order_relaxed);
    else
      self->read();
  });
}

bool PageClient::is_flooding(std::size_t bytes) {
  const double now = station_us();
  if (now - budget_since_us_ > 1e6) {
    budget_since_us_ = now;
    budget_messages_ = budget_bytes_ = 0;
  }
  return ++budget_messages_ > kMostMessagesASecond || (budget_bytes_ += bytes) > kMostBytesASecond;
}

void PageClient::take(std::string_view text) {
  const double now = station_us();
  const PageMessage message = read_message(text, host_.scenes);
  if (const auto* input = std::get_if<InputMessage>(&message)) return take(*input, now);
  if (const auto* control = std::get_if<ControlMessage>(&message)) return take(*control);
  if (const auto* seen = std::get_if<SeenMessage>(&message)) return take(*seen);
  if (const auto* drawn = std::get_if<DrawnMessage>(&message)) return take(*drawn);
  if (std::holds_alternative<GarbageMessage>(message)) return close(websocket::close_code::bad_payload);
  if (const auto* ping = std::get_if<PingMessage>(&message))
    return tell(std::make_shared<const std::string>(pong_json(ping->stamp, now, station_us())));
  tell(std::make_shared<const std::string>(error_json(std::get<RefusedMessage>(message).text)));
}

void PageClient::take(const InputMessage& message, double now) {
  host_.take_hand(id_, {message.hand, {id_, message.number, message.stamp, now}});
}

void PageClient::take(const ControlMessage& message) {
  for (const Control& control : message.controls)
    if (!host_.exchange.controls.push(control))
      host_.figures.controls_refused.fetch_add(1, std::memory_order_relaxed);
  if (message.camera) {
    const auto [camera, on] = *message.camera;
    host_.failed_cameras = (host_.failed_cameras & ~(1U << camera)) | static_cast<unsigned>(on) << camera;
    host_.tell_state();
  }
  if (message.debrief)
    tell(std::make_shared<const std::string>(debrief_json(host_.state, host_.scenes, host_.path, host_.log)),
         Text::debrief);
}

void PageClient::take(const SeenMessage& message) {
  reports_seen_ = true;
  // Frames are seen in the order in which they were sent.
  for (std::uint64_t i = frames_seen_; i < frames_sent_; ++i) {
    if (sent_[i % sent_.size()].frame != message.frame) continue;
    if (i == first_unseen_) first_took_us_ = station_us() - sent_[i % sent_.size()].sent_us;
    frames_seen_ = i + 1;
  }
  pump();
}

void PageClient::take(const DrawnMessage& message) {
  rtt_us_ = message.rtt;
  for (const Sent& sent : sent_) {
    if (sent.frame != message.frame || sent.sent_us == 0.0) continue;
    // Of each input the first frame that obeys it counts.
    if (sent.input.client != id_ || sent.input.number == drawn_input_ ||
        !std::isfinite(sent.input.browser_us))
      return;
    drawn_input_ = sent.input.number;
    LatencyFigures& latency = host_.latency;
    const double input_us = sent.input.browser_us + message.offset, drawn_us = message.stamp + message.offset;
    const std::array<double, 5> stages = {
        sent.input.received_us - input_us, sent.started_us - sent.input.received_us,
        sent.decided_us - sent.started_us, sent.sent_us - sent.decided_us, drawn_us - sent.sent_us};
    latency.input_to_received.add(stages[0]);
    latency.received_to_started.add(stages[1]);
    latency.started_to_decided.add(stages[2]);
    latency.decided_to_sent.add(stages[3]);
    latency.sent_to_drawn.add(stages[4]);
    const double end_to_end = message.stamp - sent.input.browser_us;
    latency.input_to_drawn.add(end_to_end);
    // Stages below 0 show an offset that is off: they count as what they are, 0, and the sum says by how
    // much.
    double sum = 0.0;
    for (const double stage : stages) sum += std::max(0.0, stage);
    latency.difference.add(std::abs(sum - end_to_end));
    host_.offset_us = message.offset;
    host_.rtt_us = message.rtt;
    return;
  }
}

// ---- out

std::size_t PageClient::bytes_waiting() const {
  std::size_t bytes = frame_.capacity();
  for (const Waiting& each : texts_) bytes += each.text->size();
  return bytes;
}

void PageClient::tell(std::shared_ptr<const std::string> text, Text about) {
  if (!is_open_ || is_closing_) return;
  // The first may be on its way.
  const auto waiting = texts_.begin() + (is_writing_ && !texts_.empty() ? 1 : 0);
  const auto is_passing = [](const Waiting& each) { return each.about == Text::passing; };
  const bool is_full =
      std::count_if(texts_.begin(), texts_.end(), is_passing) >= static_cast<std::ptrdiff_t>(kMostTexts);
  const auto replaced =
      std::find_if(waiting, texts_.end(), [about](const Waiting& each) { return each.about == about; });
  if (replaced != texts_.end() && (about != Text::passing || is_full)) {
    host_.figures.texts_dropped.fetch_add(about == Text::passing ? 1 : 0, std::memory_order_relaxed);
    texts_.erase(replaced);
  }
  texts_.push_back({std::move(text), about});
  pump();
}

bool PageClient::may_send_frame() const {
  if (sent_serial_ >= host_.frame_serial || host_.frame.size() < kFrameHeader) return false;
  if (!reports_seen_ || frames_sent_ == frames_seen_) return true;
  const double waits = station_us() - sent_[frames_seen_ % sent_.size()].sent_us;
  const double of_page = std::max(kLongUnseen, 0.75 * first_took_us_);
  return frames_sent_ - frames_seen_ == 1 &&
         waits > (rtt_us_ > kFar ? std::min(rtt_us_ / 2.0, of_page) : of_page);
}

void PageClient::pump() {
  if (!is_open_ || is_writing_ || is_closing_) return;
  if (!texts_.empty())
    send_text();
  else if (may_send_frame())
    send_frame();
}

void PageClient::send_text() {
  is_writing_ = true;
  socket_.text(true);
  const std::shared_ptr<const std::string> text = texts_.front().text;
  socket_.async_write(boost::asio::buffer(*text),
                      [self = shared_from_this(), text](beast::error_code error, std::size_t) {
                        self->is_writing_ = false;
                        if (!self->texts_.empty()) self->texts_.pop_front();
                        if (!error) self->pump();
                      });
}

void PageClient::send_frame() {
  is_writing_ = true;
  // Counted by the loop's own numbers: one frame may overwrite another before the server sees either.
  const auto number = value_at<std::uint64_t>(host_.frame, 8);
  const std::uint64_t between = sent_serial_ > 0 ? number - sent_frame_ - 1 : 0;
  overwritten_ += between;
  sent_frame_ = number;
  host_.figures.frames_overwritten.fetch_add(between, std::memory_order_relaxed);
  sent_serial_ = host_.frame_serial;
  frame_.assign(host_.frame.begin(), host_.frame.end());
  set_client_part(frame_, station_us(), overwritten_);
  note_sent();
  socket_.binary(true);
  socket_.async_write(boost::asio::buffer(frame_),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->is_writing_ = false;
                        if (error) return;
                        self->host_.figures.frames_sent.fetch_add(1, std::memory_order_relaxed);
                        self->pump();
                      });
}

void PageClient::note_sent() {
  const std::span<const std::uint8_t> bytes = frame_;
  if (frames_sent_ == frames_seen_) first_unseen_ = frames_sent_;
  Sent& sent = sent_[frames_sent_++ % sent_.size()];
  sent.frame = value_at<std::uint64_t>(bytes, 8);
  sent.input = {value_at<std::uint32_t>(bytes, 64), value_at<std::uint32_t>(bytes, 68),
                value_at<double>(bytes, 24), value_at<double>(bytes, 32)};
  sent.started_us = value_at<double>(bytes, 40);
  sent.decided_us = value_at<double>(bytes, 48);
  sent.sent_us = value_at<double>(bytes, 56);
}

}  // namespace touchstone::station
