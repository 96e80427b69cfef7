#include "touchstone/tests/station_page/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace touchstone {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr std::string_view kBase64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string to_base64(const std::string& bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kBase64[bits >> (18 - 6 * k) & 0x3fu] : '=';
  }
  return text;
}

std::string from_base64(const std::string& text) {
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    const std::size_t digit = kBase64.find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xffu);
  }
  return bytes;
}

std::string type_of(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".html" ? "text/html" : ending == ".js" ? "text/javascript" : "text/css";
}

/// In the child: Chromium reads commands from descriptor 3 and answers on 4.
[[noreturn]] void become_chromium(const std::string& program, int commands, int answers,
                                  const std::filesystem::path& profile) {
  setpgid(0, 0);  // its processes are known by their group
  const int in = fcntl(commands, F_DUPFD, 10), out = fcntl(answers, F_DUPFD, 10);
  dup2(in, 3);
  dup2(out, 4);
  const int log = ::open((profile / "said").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(log, 1);
  dup2(log, 2);
  const std::string data = "--user-data-dir=" + profile.string();
  execl(program.c_str(), program.c_str(), "--headless", "--no-sandbox", "--remote-debugging-pipe",
        "--enable-unsafe-swiftshader", "--no-first-run", "--mute-audio", "--hide-scrollbars", data.c_str(),
        static_cast<char*>(nullptr));
  _exit(127);
}

}  // namespace

std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string Browser::program() { return CHROMIUM; }

Browser::Browser(const std::filesystem::path& profile) {
  std::filesystem::create_directories(profile);
  std::array<int, 2> commands{}, answers{};
  if (pipe2(commands.data(), O_CLOEXEC) != 0 || pipe2(answers.data(), O_CLOEXEC) != 0)
    throw std::runtime_error("no pipe");
  process_ = fork();
  if (process_ == 0) become_chromium(program(), commands[0], answers[1], profile);
  close(commands[0]);
  close(answers[1]);
  to_browser_ = commands[1];
  from_browser_ = answers[0];
  signal(SIGPIPE, SIG_IGN);  // a browser that is gone is an error of the next call
  const json target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ =
      call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
  for (const char* const domain : {"Page", "Runtime", "Network", "Log"})
    call(std::string(domain) + ".enable");
}

Browser::~Browser() {
  close(to_browser_);
  close(from_browser_);
  // It goes by itself when its pipe closes; what does not within two seconds is ended.
  const auto start = Clock::now();
  while (waitpid(process_, nullptr, WNOHANG) == 0) {
    if (seconds_since(start) > 2.0) kill(process_, SIGKILL);
    poll(nullptr, 0, 5);
  }
}

void Browser::serve(const std::string& origin, const std::filesystem::path& folder) {
  origin_ = origin;
  folder_ = folder;
  call("Fetch.enable", {{"patterns", {{{"urlPattern", "*"}}}}});
}

void Browser::run_before_pages(const std::string& script) {
  call("Page.addScriptToEvaluateOnNewDocument", {{"source", script}});
}

void Browser::set_window(int width, int height, bool is_phone, double pixels) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", pixels}, {"mobile", is_phone}});
}

void Browser::set_media(const json& features) {
  call("Emulation.setEmulatedMedia", {{"features", features}});
}

void Browser::open(const std::string& address) { call("Page.navigate", {{"url", address}}); }

json Browser::evaluate(const std::string& expression) {
  const json answer = call(
      "Runtime.evaluate",
      {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}, {"userGesture", true}});
  if (answer.contains("exceptionDetails")) throw std::runtime_error(answer["exceptionDetails"].dump());
  return answer["result"].value("value", json());
}

bool Browser::becomes_true(const std::string& expression, double seconds) {
  const auto start = Clock::now();
  do {
    try {
      if (evaluate("Boolean(" + expression + ")") == true) return true;
    } catch (const std::runtime_error&) {  // a page that is still loading has not all of it
    }
    wait(0.02);
  } while (seconds_since(start) < seconds);
  return false;
}

void Browser::press(const std::string& code, bool is_down) {
  const bool is_letter = code.rfind("Key", 0) == 0;
  call("Input.dispatchKeyEvent",
       {{"type", is_down ? "rawKeyDown" : "keyUp"},
        {"code", code},
        {"key", is_letter ? std::string(1, static_cast<char>(code[3] + 32)) : code}});
}

void Browser::click(double x, double y) {
  for (const char* const type : {"mousePressed", "mouseReleased"})
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"clickCount", 1}});
}

void Browser::wait(double seconds) {
  const auto start = Clock::now();
  for (double left = seconds; left > 0.0; left = seconds - seconds_since(start)) {
    const json message = next_message(left);
    if (!message.is_null()) take_event(message);
  }
}

void Browser::save_picture(const std::filesystem::path& file, double scale) {
  json asked = {{"format", "png"}};
  if (scale != 1.0) {
    const json size = evaluate("[innerWidth, innerHeight]");
    asked["clip"] = {{"x", 0}, {"y", 0}, {"width", size[0]}, {"height", size[1]}, {"scale", scale}};
  }
  std::ofstream(file, std::ios::binary)
      << from_base64(call("Page.captureScreenshot", asked)["data"].get<std::string>());
}

double Browser::processor_seconds() const {
  double ticks = 0.0;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator("/proc")) {
    if (entry.path().filename().string().find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = read_file(entry.path() / "stat");
    const std::size_t name_end = stat.rfind(')');  // the name may hold blanks
    if (name_end == std::string::npos) continue;
    std::istringstream rest(stat.substr(name_end + 1));
    std::string skipped;
    pid_t group = 0;
    double user = 0.0, system = 0.0;
    rest >> skipped >> skipped >> group;                        // state, parent, group
    for (int field = 6; field <= 13; ++field) rest >> skipped;  // session up to major faults of children
    rest >> user >> system;
    if (group == process_) ticks += user + system;
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

json Browser::call(const std::string& method, json parameters) {
  const long number = post(method, parameters);
  const auto start = Clock::now();
  while (seconds_since(start) < 60.0) {
    const json message = next_message(1.0);
    if (message.is_null()) continue;
    if (message.value("id", 0L) != number) {
      take_event(message);
      continue;
    }
    if (message.contains("error")) throw std::runtime_error(method + ": " + message["error"].dump());
    return message["result"];
  }
  throw std::runtime_error(method + ": no answer within a minute");
}

long Browser::post(const std::string& method, const json& parameters) {
  json message = {{"id", ++last_call_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t count = write(to_browser_, text.data() + sent, text.size() - sent);
    if (count <= 0) throw std::runtime_error(method + ": the browser is gone");
    sent += static_cast<std::size_t>(count);
  }
  return last_call_;
}

json Browser::next_message(double seconds) {
  const auto start = Clock::now();
  for (;;) {
    const std::size_t end = unread_.find('\0');
    if (end != std::string::npos) {
      json message = json::parse(unread_.substr(0, end));
      unread_.erase(0, end + 1);
      return message;
    }
    const double left = seconds - seconds_since(start);
    pollfd waiting{from_browser_, POLLIN, 0};
    if (left <= 0.0 || poll(&waiting, 1, static_cast<int>(1000.0 * left) + 1) == 0) return {};
    std::array<char, 65536> bytes;
    const ssize_t count = read(from_browser_, bytes.data(), bytes.size());
    if (count <= 0) throw std::runtime_error("the browser is gone");
    unread_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

void Browser::take_event(const json& message) {
  const std::string method = message.value("method", "");
  const json parameters = message.value("params", json::object());
  if (method == "Fetch.requestPaused") answer_request(parameters);
  if (method == "Runtime.exceptionThrown") faults_.push_back(parameters.dump());
  // That tests read pixels back, which no page does, is theirs.
  if (method == "Log.entryAdded" &&
      parameters["entry"].dump().find("stall due to ReadPixels") == std::string::npos)
    faults_.push_back(parameters["entry"].dump());
  if (method == "Runtime.consoleAPICalled" &&
      (parameters["type"] == "error" || parameters["type"] == "warning"))
    faults_.push_back(parameters["args"].dump());
  if (method == "Network.requestWillBeSent") requests_.push_back(parameters["request"]["url"]);
  if (method == "Network.webSocketCreated") requests_.push_back(parameters["url"]);
}

void Browser::answer_request(const json& parameters) {
  const std::string url = parameters["request"]["url"];
  const json id = parameters["requestId"];
  const bool is_ours = url.rfind(origin_, 0) == 0;
  const std::string path =
      is_ours ? url.substr(origin_.size(), url.find_first_of("?#") - origin_.size()) : "";
  const std::filesystem::path file = folder_ / (path.empty() ? "index.html" : path);
  if (!is_ours || !std::filesystem::is_regular_file(file)) {
    strangers_.push_back(url);
    post("Fetch.failRequest", {{"requestId", id}, {"errorReason", "Failed"}});
    return;
  }
  // The station's own policy, so that a page that breaks it fails here too.
  const std::string policy =
      "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'";
  post("Fetch.fulfillRequest", {{"requestId", id},
                                {"responseCode", 200},
                                {"responseHeaders",
                                 {{{"name", "Content-Type"}, {"value", type_of(file)}},
                                  {{"name", "Content-Security-Policy"}, {"value", policy}}}},
                                {"body", to_base64(read_file(file))}});
}

}  // namespace touchstone
