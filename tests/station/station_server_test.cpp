#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/messages/frame_message.hpp"
#include "touchstone/examples/station/server/loop.hpp"
#include "touchstone/examples/station/server/scripted_hand.hpp"
#include "touchstone/examples/station/server/server.hpp"
#include "touchstone/examples/station/server/space_mouse.hpp"
#include "touchstone/tests/station/station_scenes.hpp"
#include "touchstone/tests/support/program_test.hpp"

// The server with real sockets: who is let in, what they get, and that nobody holds up the loop or fills the
// memory.

namespace touchstone::station {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;

/// A station whose loop runs at 200 Hz on a thread of its own.
class StationServer : public FolderTest {
 protected:
  StationServer() : scenes_(bundled({"grapple", "worksite"}, 200.0)) {
    write("index.html", "<!doctype html>the page");
    settings_.port = 0;
    settings_.page = folder_;
    settings_.most_clients = 12;
  }
  ~StationServer() override { end(); }

  void start() {
    session_ = std::make_unique<Session>(scenes_, 0, 8U);
    exchange_ = std::make_unique<Exchange>(most_frame_bytes(scenes_));
    judge_ = std::make_unique<MergeJudge>(scenes_);
    server_ = std::make_unique<Server>(settings_, *exchange_, scenes_, 0, 200.0, nullptr);
    loop_ = std::make_unique<StationLoop>(*session_, *exchange_, *judge_, nullptr);
    thread_ = std::thread([this] { loop_->run(stop_); });
  }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }

  std::string host() const { return "127.0.0.1:" + std::to_string(server_->port()); }

  /// Frames that the loop flies in some time.
  std::uint64_t frames_in(std::chrono::milliseconds time) const {
    const std::uint64_t before = exchange_->figures.frame.load();
    std::this_thread::sleep_for(time);
    return exchange_->figures.frame.load() - before;
  }

  /// True as soon as it holds, within five seconds.
  template <class Condition>
  static bool becomes(const Condition& condition) {
    const auto end = Clock::now() + std::chrono::seconds(5);
    while (!condition() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return condition();
  }

  /// Of the hand, from where the scene has it. After end().
  double distance_flown() const {
    const std::uint32_t hand = scenes_[0]->hand_object();
    return norm(session_->flight().ours().poses()[hand].p - scenes_[0]->setting.scene().objects[hand].X_WO.p);
  }

  const StationScenes scenes_;
  ServerSettings settings_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<MergeJudge> judge_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StationLoop> loop_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A browser's side of a socket.
class Page {
 public:
  explicit Page(std::uint16_t port) : port_(port) {
    socket_.next_layer().connect({asio::ip::make_address("127.0.0.1"), port});
    socket_.next_layer().set_option(tcp::no_delay(true));
  }
  /// The status of the answer; 101: it is let in.
  unsigned join(const std::string& target = "/socket", std::string origin = "", std::string host = "") {
    const std::string own = "127.0.0.1:" + std::to_string(port_);
    if (host.empty()) host = own;
    if (origin.empty()) origin = "http://" + own;
    socket_.set_option(websocket::stream_base::decorator([origin](websocket::request_type& request) {
      if (origin != "none") request.set(http::field::origin, origin);
      request.set(http::field::sec_websocket_protocol, "touchstone-station-1");
    }));
    beast::error_code error;
    socket_.handshake(host, target, error);
    return error ? refusal(target, origin, host) : 101;
  }
  /// Beast keeps the answer of who declined to itself: asked once more, as plain HTTP.
  unsigned refusal(const std::string& target, const std::string& origin, const std::string& host) {
    tcp::socket socket(context_);
    socket.connect({asio::ip::make_address("127.0.0.1"), port_});
    http::request<http::empty_body> request(http::verb::get, target, 11);
    request.set(http::field::host, host);
    request.set(http::field::connection, "Upgrade");
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::sec_websocket_version, "13");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    if (origin != "none") request.set(http::field::origin, origin);
    http::write(socket, request);
    beast::flat_buffer buffer;
    http::response<http::string_body> response;
    http::read(socket, buffer, response);
    return response.result_int();
  }
  void say(const std::string& text) {
    socket_.text(true);
    socket_.write(asio::buffer(text));
  }
  void say_bytes(const std::string& bytes) {
    socket_.binary(true);
    socket_.write(asio::buffer(bytes));
  }
  /// The next message. False: the socket was closed.
  bool read() {
    buffer_.clear();
    beast::error_code error;
    socket_.read(buffer_, error);
    return !error;
  }
  bool is_text() const { return socket_.got_text(); }
  nlohmann::json json() const { return nlohmann::json::parse(beast::buffers_to_string(buffer_.cdata())); }
  /// The next text of that type.
  nlohmann::json wait_for(const std::string& type) {
    while (read())
      if (is_text() && json()["type"] == type) return json();
    return {};
  }
  /// The next frame's bytes.
  std::string wait_for_frame() {
    while (read())
      if (!is_text()) return beast::buffers_to_string(buffer_.cdata());
    return {};
  }
  /// Reads to the end; the reason for which the station closed.
  unsigned closed_because() {
    while (read()) {
    }
    return socket_.reason().code;
  }
  websocket::stream<tcp::socket>& socket() { return socket_; }

 private:
  std::uint16_t port_;
  asio::io_context context_;
  websocket::stream<tcp::socket> socket_{context_};
  beast::flat_buffer buffer_;
};

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T out{};
  std::memcpy(&out, bytes.data() + offset, sizeof(T));
  return out;
}

/// In a frame.
std::uint32_t input_of(const std::string& frame) { return at<std::uint32_t>(frame, 68); }
Vector3 place_of(const std::string& frame, std::uint32_t object) {
  const std::size_t first = kFrameHeader + 64 * at<std::uint16_t>(frame, 76) + 32 * object;
  return {at<float>(frame, first), at<float>(frame, first + 4), at<float>(frame, first + 8)};
}

/// The number of the last input, once no other has come for 400 frames, 2 s at least, and the hand has stood
/// still for as long: one that is held is said twenty times meanwhile. 0: that was not so within a minute.
std::uint32_t last_input(Page& page, std::uint32_t hand) {
  const auto end = Clock::now() + std::chrono::minutes(1);
  std::string first = page.wait_for_frame();
  while (!first.empty() && Clock::now() < end) {
    const std::string frame = page.wait_for_frame();
    if (frame.empty() || input_of(frame) == 0 || input_of(frame) != input_of(first) ||
        norm(place_of(frame, hand) - place_of(first, hand)) > 1e-6)
      first = frame;
    else if (at<std::uint64_t>(frame, 8) - at<std::uint64_t>(first, 8) >= 400)
      return input_of(frame);
  }
  return 0;
}

struct Answer {
  unsigned status;
  std::string body;
  std::string policy, cookie;
};

Answer get(std::uint16_t port, const std::string& target, const std::string& host,
           const std::string& cookie = "", http::verb verb = http::verb::get) {
  asio::io_context context;
  tcp::socket socket(context);
  socket.connect({asio::ip::make_address("127.0.0.1"), port});
  http::request<http::string_body> request(verb, target, 11);
  request.set(http::field::host, host);
  if (!cookie.empty()) request.set(http::field::cookie, cookie);
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  beast::error_code error;
  http::read(socket, buffer, response, error);
  const auto text = [&](beast::string_view view) { return std::string(view.data(), view.size()); };
  return {response.result_int(), response.body(), text(response["Content-Security-Policy"]),
          text(response[http::field::set_cookie])};
}

TEST_F(StationServer, ServesThePageAndItsFiguresToThisMachineAlone) {
  start();
  const Answer page = get(server_->port(), "/", host());
  EXPECT_EQ(page.status, 200U);
  EXPECT_EQ(page.body, "<!doctype html>the page");
  EXPECT_NE(page.policy.find("default-src 'self'"), std::string::npos);
  EXPECT_EQ(
      nlohmann::json::parse(get(server_->port(), "/latency.json", host()).body)["deadline"]["period_us"],
      5000.0);
  EXPECT_GT(nlohmann::json::parse(get(server_->port(), "/status.json", host()).body)["accepted"], 0);
  EXPECT_EQ(get(server_->port(), "/../secret", host()).status, 404U);
  EXPECT_EQ(get(server_->port(), "/", "evil.example:" + std::to_string(server_->port())).status, 403U);
  EXPECT_EQ(get(server_->port(), "/", host(), "", http::verb::delete_).status, 405U);
}

#ifdef TOUCHSTONE_ROBOTS
class StationServerOfARobot : public FolderTest {};

TEST_F(StationServerOfARobot, ServesItsMeshes) {
  SceneRobots robots;
  robots.choices.over = "box";
  robots.choices.sphere_facets = 8;
  StationScenes scenes;
  scenes.push_back(load_station_scene(TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf", 200.0, robots));
  ServerSettings settings;
  settings.port = 0;
  settings.page = write("index.html", "the page").parent_path();
  Exchange exchange(most_frame_bytes(scenes));
  const Server server(settings, exchange, scenes, 0, 200.0, nullptr);
  const std::string host = "127.0.0.1:" + std::to_string(server.port());
  const Answer meshes = get(server.port(), "/" + scenes[0]->meshes.path, host);
  EXPECT_EQ(meshes.status, 200U);
  EXPECT_EQ(meshes.body, scenes[0]->meshes.bytes);
  EXPECT_FALSE(meshes.body.empty());
  EXPECT_EQ(get(server.port(), "/meshes/0000000000000000", host).status, 404U);
  EXPECT_EQ(get(server.port(), "/meshes/", host).status, 404U);
}
#endif

TEST_F(StationServer, SaysHelloAndTheSceneBeforeItsFrames) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  for (const char* type : {"hello", "scene", "state"}) {
    ASSERT_TRUE(page.read());
    EXPECT_EQ(page.json()["type"], type);
    if (type == std::string("hello")) {
      EXPECT_EQ(page.json()["version"], 2);
    }
    EXPECT_EQ(page.json().contains("rates"), type == std::string("scene"));
  }
  const std::string frame = page.wait_for_frame();
  EXPECT_EQ(at<std::uint32_t>(frame, 0), kFrameMagic);
  EXPECT_EQ(at<std::uint32_t>(frame, 108), frame.size());
  EXPECT_GT(at<double>(frame, 56), at<double>(frame, 48));
}

TEST_F(StationServer, TakesAHandAndSaysWhichInputAFrameObeys) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  const std::uint32_t client = page.wait_for("hello")["client"];
  page.say(
      R"({"type": "input", "number": 5, "stamp": 777.0, "translation": [1, 0, 0], "rotation": [0, 0, 0]})");
  std::string frame;
  do {
    frame = page.wait_for_frame();
    ASSERT_FALSE(frame.empty());
  } while (at<std::uint32_t>(frame, 68) != 5);
  EXPECT_EQ(at<std::uint32_t>(frame, 64), client);
  EXPECT_EQ(at<double>(frame, 24), 777.0);
  // Stamps in the order of the stages: received, begun, decided, sent.
  EXPECT_LE(at<double>(frame, 32), at<double>(frame, 40));
  EXPECT_LE(at<double>(frame, 40), at<double>(frame, 48));
  EXPECT_LE(at<double>(frame, 48), at<double>(frame, 56));
  // Drawn 5 ms after it was sent, however long the step had to be waited for.
  const double end_to_end = at<double>(frame, 56) - at<double>(frame, 32) + 5000.0;
  page.say(R"({"type": "drawn", "frame": )" + std::to_string(at<std::uint64_t>(frame, 8)) + R"(, "stamp": )" +
           std::to_string(777.0 + end_to_end) + R"(, "offset": )" +
           std::to_string(at<double>(frame, 32) - 777.0) + R"(, "rtt": 3})");
  EXPECT_TRUE(becomes([&] { return server_->latency().input_to_drawn.count() == 1; }));
  EXPECT_NEAR(server_->latency().input_to_drawn.worst_us(), end_to_end, 0.01);
  EXPECT_LT(server_->latency().difference.worst_us(), 1000.0);
}

TEST_F(StationServer, SendsTheOtherSceneToAllWhoWatch) {
  start();
  Page pilot(server_->port()), other(server_->port());
  ASSERT_EQ(pilot.join(), 101U);
  ASSERT_EQ(other.join(), 101U);
  EXPECT_EQ(other.wait_for("scene")["name"], "grapple");
  pilot.say(R"({"type": "control", "scene": "worksite"})");
  const nlohmann::json scene = other.wait_for("scene");
  EXPECT_EQ(scene["name"], "worksite");
  EXPECT_EQ(scene["serial"], 2);
  std::string frame = other.wait_for_frame();
  while (!frame.empty() && at<std::uint32_t>(frame, 112) != 2) frame = other.wait_for_frame();
  EXPECT_EQ(at<std::uint32_t>(frame, 72), scene["objects"].size());
}

TEST_F(StationServer, LetsNobodyInFromElsewhere) {
  start();
  const std::string port = std::to_string(server_->port());
  EXPECT_EQ(Page(server_->port()).join("/socket", "http://evil.example"), 403U);
  EXPECT_EQ(Page(server_->port()).join("/socket", "none"), 403U);
  EXPECT_EQ(Page(server_->port()).join("/socket", "null"), 403U);
  EXPECT_EQ(Page(server_->port()).join("/socket", "http://evil.example:" + port, "evil.example:" + port),
            403U);
  EXPECT_EQ(Page(server_->port()).join("/socket", "http://127.0.0.1:1"), 403U);
  EXPECT_NE(Page(server_->port()).join("/other"), 101U);
  EXPECT_EQ(server_->figures().clients.load(), 0U);
  EXPECT_EQ(Page(server_->port()).join(), 101U);
}

TEST_F(StationServer, BeyondLoopbackAsksForATokenAndTakesItsCookie) {
  settings_.bind = "0.0.0.0";
  EXPECT_THROW(start(), InputError);
  settings_.token = "0123456789abcdef";
  settings_.udp_port = 1;
  EXPECT_THROW(start(), InputError);  // datagrams bring no token
  settings_.udp_port = 0;
  start();
  EXPECT_EQ(get(server_->port(), "/", host()).status, 403U);
  EXPECT_EQ(get(server_->port(), "/?token=wrong", host()).status, 403U);
  const Answer page = get(server_->port(), "/?token=0123456789abcdef", host());
  EXPECT_EQ(page.status, 200U);
  EXPECT_NE(page.cookie.find("SameSite=Strict"), std::string::npos);
  EXPECT_EQ(get(server_->port(), "/", host(), page.cookie.substr(0, page.cookie.find(';'))).status, 200U);
  EXPECT_EQ(Page(server_->port()).join(), 403U);
  EXPECT_EQ(Page(server_->port()).join("/socket?token=0123456789abcdef"), 101U);
  EXPECT_EQ(Page(server_->port()).join("/socket?token=0123456789abcdef", "http://evil.example"), 403U);
}

TEST_F(StationServer, ClosesTheSocketOfGarbageAndNoOther) {
  // Somebody who watches.
  start();
  Page watcher(server_->port());
  ASSERT_EQ(watcher.join(), 101U);
  // Text that is no message, bytes, and too much of either end the connection.
  const auto reason_for = [&](const auto& say) {
    Page page(server_->port());
    EXPECT_EQ(page.join(), 101U);
    say(page);
    return page.closed_because();
  };
  EXPECT_EQ(reason_for([](Page& page) { page.say("garbage"); }), 1007U);
  EXPECT_EQ(reason_for([](Page& page) { page.say_bytes(std::string(100, '\0')); }), 1003U);
  EXPECT_EQ(reason_for([](Page& page) { page.say(std::string(70'000, ' ')); }), 1009U);
  EXPECT_EQ(reason_for([](Page& page) {
              beast::error_code error;
              for (int i = 0; i < 5000 && !error; ++i)
                page.socket().write(asio::buffer(std::string(R"({"type": "ping", "stamp": 1})")), error);
            }) / 1000,
            1U);
  // A message of an unknown type does not, and others go on.
  Page refused(server_->port());
  ASSERT_EQ(refused.join(), 101U);
  refused.say(R"({"type": "fly"})");
  EXPECT_EQ(refused.wait_for("error")["text"], "no message of type 'fly'");
  EXPECT_FALSE(watcher.wait_for_frame().empty());
  EXPECT_GT(frames_in(std::chrono::milliseconds(100)), 0U);
}

/// Says that a message of 1 GB follows, and sends what the station takes of it.
TEST_F(StationServer, ReadsNothingOfAMessageOfAGigabyte) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  tcp::socket& raw = page.socket().next_layer();
  // A masked text frame with a 64-bit length of 1e9.
  const std::array<unsigned char, 14> head = {0x81, 0xff, 0, 0, 0, 0, 0x3b, 0x9a, 0xca, 0x00, 1, 2, 3, 4};
  beast::error_code error;
  asio::write(raw, asio::buffer(head), error);
  EXPECT_EQ(page.closed_because(), 1009U);
  EXPECT_TRUE(becomes([&] { return server_->figures().clients.load() == 0; }));
  EXPECT_LT(server_->figures().most_bytes_waiting.load(), std::uint64_t{1} << 20U);
}

TEST_F(StationServer, RefusesClientsBeyondItsNumberAndFreesTheirPlaces) {
  start();
  std::vector<std::unique_ptr<Page>> pages;
  for (std::size_t i = 0; i < settings_.most_clients; ++i) {
    pages.push_back(std::make_unique<Page>(server_->port()));
    EXPECT_EQ(pages.back()->join(), 101U);
  }
  EXPECT_EQ(Page(server_->port()).join(), 503U);
  pages.pop_back();
  EXPECT_TRUE(becomes([&] { return Page(server_->port()).join() == 101U; }));
}

/// Ten pages that read nothing, one whose plug is pulled in the middle, and garbage: the loop goes on, each
/// client has one frame under way, and those who come back see the newest.
TEST_F(StationServer, TenClientsThatDoNotReadFillNoQueue) {
  start();
  std::vector<std::unique_ptr<Page>> pages;
  for (int i = 0; i < 10; ++i) {
    pages.push_back(std::make_unique<Page>(server_->port()));
    pages.back()->socket().next_layer().set_option(asio::socket_base::receive_buffer_size(4096));
    ASSERT_EQ(pages.back()->join(), 101U);
  }
  EXPECT_TRUE(becomes([&] { return server_->figures().clients.load() == 10; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  pages[3]->socket().next_layer().set_option(asio::socket_base::linger(true, 0));
  pages[3]->socket().next_layer().close();  // a reset, no word
  const std::uint64_t flown = frames_in(std::chrono::milliseconds(500));
  EXPECT_GT(flown, 20U);  // of 100: the machine may be busy
  EXPECT_TRUE(becomes([&] { return server_->figures().clients.load() == 9; }));
  // One frame and what a page gets at once, a client; the scene's text is the largest.
  const std::size_t most = most_frame_bytes(scenes_) + 64 * 1024;
  EXPECT_LT(server_->figures().most_bytes_waiting.load(), 10 * most);
  EXPECT_GT(server_->figures().frames_overwritten.load() + server_->figures().frames_sent.load(), 0U);
  EXPECT_FALSE(pages[0]->wait_for_frame().empty());
}

void say_seen(Page& page, const std::string& frame) {
  page.say(R"({"type": "seen", "frame": )" + std::to_string(at<std::uint64_t>(frame, 8)) + "}");
}

/// Takes the frames that were sent before the first `seen` was, and says of each that it was seen.
void take_those_on_their_way(Page& page) {
  for (int i = 0; i < 41; ++i) say_seen(page, page.wait_for_frame());
}

TEST_F(StationServer, KeepsTheNewestBackFromAPageThatHasNotSeenTheLast) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  take_those_on_their_way(page);
  const std::uint64_t before = server_->figures().frames_sent.load();
  EXPECT_GT(frames_in(std::chrono::milliseconds(300)), 10U);
  EXPECT_LE(server_->figures().frames_sent.load() - before, 3U);
  // One came at once, a second not before it had waited for long.
  const std::string first = page.wait_for_frame();
  std::string frame = page.wait_for_frame();
  EXPECT_GT(at<double>(frame, 56) - at<double>(first, 56), 100e3);
  say_seen(page, frame);
  // Seen again: the newest comes, not those in between.
  std::uint64_t last = 0;
  for (int i = 0; i < 4; ++i) {
    frame = page.wait_for_frame();
    say_seen(page, frame);
    EXPECT_GT(at<std::uint64_t>(frame, 8), last);
    last = at<std::uint64_t>(frame, 8);
  }
  EXPECT_GT(at<std::uint64_t>(frame, 96), 5U);
}

TEST_F(StationServer, ASecondFrameSetsOutToAPageFarAwayWhenTheFirstArrives) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  page.say(R"({"type": "drawn", "frame": 1, "stamp": 0, "offset": 0, "rtt": 60000})");
  take_those_on_their_way(page);
  // The least of some: the machine may be busy.
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 10; ++i) {
    const std::string first = page.wait_for_frame(), second = page.wait_for_frame();
    least = std::min(least, at<double>(second, 56) - at<double>(first, 56));
    say_seen(page, second);
  }
  EXPECT_GT(least, 30e3);
  EXPECT_LT(least, 100e3);
}

TEST_F(StationServer, OneHandAtATimeFlies) {
  start();
  Page pilot(server_->port()), other(server_->port());
  ASSERT_EQ(pilot.join(), 101U);
  ASSERT_EQ(other.join(), 101U);
  const std::uint32_t first = pilot.wait_for("hello")["client"], second = other.wait_for("hello")["client"];
  pilot.say(R"({"type": "input", "number": 1, "stamp": 0, "translation": [0.1, 0, 0]})");
  while (pilot.wait_for("state")["pilot"] != first) {
  }
  other.say(R"({"type": "input", "number": 1, "stamp": 0, "translation": [0, 0, 0]})");  // holds nothing: no
                                                                                         // taking over
  pilot.say(R"({"type": "input", "number": 2, "stamp": 0, "translation": [0.1, 0, 0]})");
  std::string frame = pilot.wait_for_frame();
  while (at<std::uint32_t>(frame, 68) != 2) frame = pilot.wait_for_frame();
  EXPECT_EQ(at<std::uint32_t>(frame, 64), first);
  pilot.say(R"({"type": "input", "number": 3, "stamp": 0})");  // lets go
  while (!frame.empty() && input_of(frame) != 3) frame = pilot.wait_for_frame();
  other.say(R"({"type": "input", "number": 2, "stamp": 0, "translation": [0, 0.1, 0]})");
  bool took_over = false;
  for (int i = 0; i < 1000 && !took_over && other.read(); ++i)
    took_over = other.is_text() && other.json()["type"] == "state" && other.json()["pilot"] == second;
  EXPECT_TRUE(took_over);
}

TEST_F(StationServer, TakesHandsFromDatagramsAndPassesOthersBy) {
  asio::io_context context;
  asio::ip::udp::socket socket(context, asio::ip::udp::endpoint(asio::ip::make_address("127.0.0.1"), 0));
  {  // a port that is free now
    asio::ip::udp::socket free(context, asio::ip::udp::endpoint(asio::ip::make_address("127.0.0.1"), 0));
    settings_.udp_port = free.local_endpoint().port();
  }
  start();
  const asio::ip::udp::endpoint station(asio::ip::make_address("127.0.0.1"), settings_.udp_port);
  std::array<unsigned char, 64> datagram{};
  const std::uint32_t magic = 0x31555354;
  const double rate = 0.5;
  std::memcpy(datagram.data(), &magic, 4);
  std::memcpy(datagram.data() + 8, &rate, 8);
  socket.send_to(asio::buffer("garbage", 7), station);
  socket.send_to(asio::buffer(std::string(2000, 'x')), station);
  socket.send_to(asio::buffer(datagram), station);
  EXPECT_TRUE(becomes([&] {
    return server_->figures().datagrams.load() == 1 && server_->figures().bad_datagrams.load() == 2;
  }));
  EXPECT_TRUE(becomes([&] { return exchange_->figures.frame.load() > 50; }));
  end();
  EXPECT_GT(session_->flight().figures().path, 0.0);
}

TEST_F(StationServer, EndsWithClientsAndHalfRequestsOpen) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  asio::io_context context;
  tcp::socket half(context);
  half.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
  asio::write(half, asio::buffer(std::string("GET / HT")));
  const auto before = Clock::now();
  end();
  EXPECT_LT(Clock::now() - before, std::chrono::seconds(5));
}

// ---- hands that are no page

TEST_F(StationServer, AScriptedHandFliesAndIsTimed) {
  start();
  {
    const ScriptedHand hand(*server_, 100.0);
    EXPECT_TRUE(becomes([&] { return exchange_->figures.answer.count() > 50; }));
  }
  end();
  EXPECT_GT(distance_flown(), 1e-3);
  // A period is 5 ms; how long a busy machine takes is recorded.
  const double median = exchange_->figures.answer.quantile_us(0.5);
  EXPECT_GT(median, 0.0);
  RecordProperty("us_from_hand_to_answer", static_cast<int>(median));
  EXPECT_NE(figures_text(exchange_->figures, {}).find("hands that were obeyed: "), std::string::npos);
}

TEST_F(StationServer, TheNewestOfManyHandsIsObeyed) {
  start();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  for (std::uint32_t number = 1; number <= 100'000; ++number)
    server_->fly(kScriptClient, number, ahead(0.01));
  std::string frame = page.wait_for_frame();
  for (int i = 0; i < 10'000 && !frame.empty() && input_of(frame) != 100'000; ++i)
    frame = page.wait_for_frame();
  ASSERT_FALSE(frame.empty());
  EXPECT_EQ(input_of(frame), 100'000U);
  EXPECT_EQ(at<std::uint32_t>(frame, 64), kScriptClient);
}

TEST(StationSpaceMouse, ItsAxesBecomeTheHands) {
  HandInput hand;
  ASSERT_TRUE(take_space_event({0, 35, 70, -175, 1000, 35, -70, 16}, hand));
  EXPECT_EQ(hand.translation, Vector3(0.5, -0.1, 0.2));
  EXPECT_EQ(hand.rotation, Vector3(0.2, -1.0, 0.1));
  const HandInput before = hand;
  EXPECT_FALSE(take_space_event({1, 3, 0, 0, 0, 0, 0, 0}, hand)) << "a button";
  EXPECT_TRUE(hand == before);
}

/// Spacenav's daemon, as far as a client sees it.
class Daemon {
 public:
  explicit Daemon(const std::filesystem::path& path)
      : acceptor_(context_, {path.string()}), socket_(context_) {}
  void accept() { acceptor_.accept(socket_); }
  void send(const SpaceEvent& event, std::size_t first = 0, std::size_t last = sizeof(SpaceEvent)) {
    asio::write(socket_, asio::buffer(reinterpret_cast<const char*>(event.data()) + first, last - first));
  }
  void end() { socket_.close(); }

 private:
  asio::io_context context_;
  asio::local::stream_protocol::acceptor acceptor_;
  asio::local::stream_protocol::socket socket_;
};

TEST_F(StationServer, ASpaceMouseFliesUntilItsDaemonEnds) {
  start();
  Daemon daemon(folder_ / "spnav.sock");
  const SpaceMouse mouse(*server_, folder_ / "spnav.sock");
  EXPECT_TRUE(mouse.is_there()) << mouse.text();
  daemon.accept();
  // An event that comes in two parts is one event.
  daemon.send({0, 0, 0, -175, 0, 0, 0, 16}, 0, 10);
  daemon.send({0, 0, 0, -175, 0, 0, 0, 16}, 10);
  EXPECT_TRUE(becomes([&] { return exchange_->figures.answer.count() > 5; })) << "held, and said again";
  daemon.end();
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  EXPECT_GT(last_input(page, scenes_[0]->hand_object()), 5U) << "let go";
  end();
  EXPECT_GT(distance_flown(), 1e-3);
}

TEST_F(StationServer, ASpaceMouseWhoseDaemonFallsSilentIsLetGo) {
  start();
  Daemon daemon(folder_ / "spnav.sock");
  std::optional<SpaceMouse> mouse(std::in_place, *server_, folder_ / "spnav.sock");
  daemon.accept();
  const SpaceEvent held = {0, 0, 0, -175, 0, 0, 0, 16};
  daemon.send(held);
  Page page(server_->port());
  ASSERT_EQ(page.join(), 101U);
  EXPECT_GT(last_input(page, scenes_[0]->hand_object()), 2U) << "held for a while, and let go";
  const std::uint64_t hands = exchange_->figures.answer.count();
  daemon.send(held);
  EXPECT_TRUE(becomes([&] { return exchange_->figures.answer.count() > hands; })) << "flies again";
  mouse.reset();  // it sends to the server until then
  end();
  EXPECT_GT(distance_flown(), 1e-3);
}

TEST_F(StationServer, AMissingSpaceMouseIsSaid) {
  start();
  const SpaceMouse mouse(*server_, folder_ / "none.sock");
  EXPECT_FALSE(mouse.is_there());
  EXPECT_EQ(mouse.text(),
            "no SpaceMouse: spacenav's " + (folder_ / "none.sock").string() + ": No such file or directory");
}

}  // namespace
}  // namespace touchstone::station
