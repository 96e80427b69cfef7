#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace touchstone {

std::string read_file(const std::filesystem::path& path);

/// Chromium without a window and without a graphics card, driven over its debugging pipe (the DevTools
/// protocol; messages end in a zero byte). Needs no package but Chromium.
class Browser {
 public:
  /// The Chromium that was found when this was configured; empty: none.
  static std::string program();

  /// @param profile a folder of its own, for what Chromium keeps and says
  /// @throws std::runtime_error where it does not start.
  explicit Browser(const std::filesystem::path& profile);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Answers every request to `origin` ("http://station.test/") with the files of `folder`; any other request
  /// fails and is kept in strangers().
  void serve(const std::string& origin, const std::filesystem::path& folder);
  /// Runs `script` before the scripts of every page opened from now on.
  void run_before_pages(const std::string& script);
  /// In CSS pixels, each of `pixels` of the screen's, each way.
  void set_window(int width, int height, bool is_phone = false, double pixels = 1.0);
  /// E.g. prefers-color-scheme, dark.
  void set_media(const nlohmann::json& features);
  void open(const std::string& address);

  /// The value of a JavaScript expression; a promise is awaited.
  /// @throws std::runtime_error with what it threw.
  nlohmann::json evaluate(const std::string& expression);
  /// Whether `expression` came true within this time [s].
  bool becomes_true(const std::string& expression, double seconds = 20.0);
  /// Presses (or lets go) a physical key, e.g. "KeyW".
  void press(const std::string& code, bool is_down = true);
  void click(double x, double y);
  void wait(double seconds);
  /// @param scale of the window's pixels, below 1: smaller, and smoothed.
  void save_picture(const std::filesystem::path& file, double scale = 1.0);
  /// Processor time of all of Chromium's processes so far [s]: says on a busy machine too what drawing takes.
  double processor_seconds() const;

  /// A command of the DevTools protocol. @throws std::runtime_error with the error or after a minute.
  nlohmann::json call(const std::string& method, nlohmann::json parameters = nlohmann::json::object());

  /// Exceptions, errors and warnings of pages so far.
  const std::vector<std::string>& faults() const { return faults_; }
  /// Addresses that pages asked for so far, and those of them that are not below the served origin.
  const std::vector<std::string>& requests() const { return requests_; }
  const std::vector<std::string>& strangers() const { return strangers_; }

 private:
  long post(const std::string& method, const nlohmann::json& parameters);
  nlohmann::json next_message(double seconds);
  void take_event(const nlohmann::json& message);
  void answer_request(const nlohmann::json& parameters);

  pid_t process_ = -1;
  int to_browser_ = -1, from_browser_ = -1;
  long last_call_ = 0;
  std::string session_, unread_, origin_;
  std::filesystem::path folder_;
  std::vector<std::string> faults_, requests_, strangers_;
};

}  // namespace touchstone
