#include "touchstone/examples/program/terminal/engine_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <stdexcept>

namespace touchstone::program {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;
#else
constexpr bool kIsSanitized = false;
#endif

// Of the one log; read in a handler and by the thread that answers signals.
std::atomic<int> log_file{-1}, saved_out{STDOUT_FILENO}, saved_err{STDERR_FILENO};

/// A file without a name, which goes with its descriptor.
int open_unnamed() {
  std::string name = (std::filesystem::temp_directory_path() / "touchstone_engines.XXXXXX").string();
  const int file = mkostemp(name.data(), O_APPEND | O_CLOEXEC);
  if (file < 0) throw std::runtime_error(name + ": " + std::strerror(errno));
  unlink(name.c_str());
  return file;
}

void flush_streams() {
  std::cout.flush();
  std::cerr.flush();
  std::fflush(stdout);
  std::fflush(stderr);
}

std::string read_from(int file, std::size_t most) {
  std::string text(most, '\0');
  std::size_t done = 0;
  for (ssize_t count = 1; done < most && count > 0; done += static_cast<std::size_t>(count)) {
    count = pread(file, text.data() + done, most - done, static_cast<off_t>(done));
    if (count < 0) break;
  }
  text.resize(done);
  return text;
}

/// An engine's last words, and then the end that it wanted. Calls only what a handler may.
void on_abort(int signal) {
  std::array<char, 2048> end;
  struct stat status {};
  fstat(log_file, &status);
  const off_t from =
      status.st_size > static_cast<off_t>(end.size()) ? status.st_size - static_cast<off_t>(end.size()) : 0;
  const ssize_t count = pread(log_file, end.data(), end.size(), from);
  if (count > 0 && ::write(saved_err, end.data(), static_cast<std::size_t>(count)) < 0) _exit(128 + signal);
  std::signal(signal, SIG_DFL);
  raise(signal);
}

}  // namespace

struct EngineLog::State {
  int file, out, err;
};

EngineLog::EngineLog() {
  if (kIsSanitized) return;
  flush_streams();
  state_ = std::make_unique<State>();
  state_->file = open_unnamed();
  state_->out = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  state_->err = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  // A stream that was closed stays closed.
  if (state_->out >= 0) saved_out = state_->out, dup2(state_->file, STDOUT_FILENO);
  if (state_->err >= 0) saved_err = state_->err, dup2(state_->file, STDERR_FILENO);
  log_file = state_->file;
  std::signal(SIGABRT, on_abort);
}

EngineLog::~EngineLog() {
  if (!state_) return;
  flush_streams();
  std::signal(SIGABRT, SIG_DFL);
  log_file = -1;
  saved_out = STDOUT_FILENO;
  saved_err = STDERR_FILENO;
  if (state_->out >= 0) dup2(state_->out, STDOUT_FILENO), close(state_->out);
  if (state_->err >= 0) dup2(state_->err, STDERR_FILENO), close(state_->err);
  close(state_->file);
}

std::string EngineLog::text() const { return state_ ? read_from(state_->file, kMostBytes) : ""; }

std::size_t engine_log_lines() {
  const int file = log_file;
  if (file < 0) return 0;
  std::array<char, 65536> part;
  std::size_t lines = 0;
  off_t at = 0;
  for (ssize_t count; (count = pread(file, part.data(), part.size(), at)) > 0; at += count)
    for (ssize_t i = 0; i < count; ++i) lines += part[static_cast<std::size_t>(i)] == '\n';
  return lines;
}

int own_stdout() { return saved_out; }
int own_stderr() { return saved_err; }

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno != EINTR) return false;
    if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

void say(std::string_view text) { write_all(own_stderr(), text); }

}  // namespace touchstone::program
