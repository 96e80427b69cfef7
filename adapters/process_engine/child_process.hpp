#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace touchstone::process_engine {

/// A program whose stdin we write and whose stdout we read; killed with what it started when this ends.
class ChildProcess {
 public:
  /// @throws InputError where it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  enum class Turn { wrote_or_read, timed_out, ended };
  /// Writes from `request` what fits and appends to `reply` what is there, at most `most` bytes of it; waits
  /// until either can be done.
  Turn exchange(std::string_view& request, std::string& reply, std::size_t most,
                std::chrono::milliseconds limit);
  /// Whether bytes are there that nobody asked for.
  bool has_more() const;
  /// Whether it waits to be asked: it has written nothing, and not ended.
  bool is_silent() const;

  /// Kills it where it still runs. Returns how it ended: "signal 11", "exit code 1".
  std::string end();

 private:
  bool write_some(std::string_view& request) const;
  bool read_some(std::string& reply, std::size_t most) const;

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;
};

}  // namespace touchstone::process_engine
