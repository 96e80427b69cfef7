#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace touchstone::program {

/// While it lives, what engines write to the standard streams by themselves is kept in a log, apart from what
/// the program says through print_now() and ProgressLine. One at a time. A program that dies in an engine
/// prints the log's end first. Without effect under a sanitizer, which reports on these streams.
class EngineLog {
 public:
  /// @throws std::runtime_error when there is no room for a temporary file.
  EngineLog();
  ~EngineLog();
  EngineLog(const EngineLog&) = delete;
  EngineLog& operator=(const EngineLog&) = delete;

  /// Returns all that was written so far, at most the first kMostBytes.
  std::string text() const;
  static constexpr std::size_t kMostBytes = std::size_t{1} << 20;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Lines that engines have written to the log; 0 without one.
std::size_t engine_log_lines();

/// Where the program itself writes: the standard streams as they were given to it.
int own_stdout();
int own_stderr();

/// Writes to one of these at once. @return whether it arrived.
bool write_all(int descriptor, std::string_view text);
/// Prints to own_stderr(); errors of that are ignored.
void say(std::string_view text);

}  // namespace touchstone::program
