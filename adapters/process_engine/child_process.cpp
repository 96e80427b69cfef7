#include "touchstone/adapters/process_engine/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "touchstone/contact_core/input_error.hpp"

extern char** environ;

namespace touchstone::process_engine {
namespace {

/// A batch fits: fewer changes between the two processes. A system that allows less is as good, slower.
constexpr int kPipeBytes = 1 << 20;

/// No SIGPIPE of our writes to a program that has ended reaches the caller's handlers, or is left pending;
/// one that was pending before still is.
class NoBrokenPipeSignal {
 public:
  NoBrokenPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoBrokenPipeSignal() {
    const timespec at_once{0, 0};
    if (!was_pending_)
      while (sigtimedwait(&pipe_, nullptr, &at_once) == SIGPIPE) continue;
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoBrokenPipeSignal(const NoBrokenPipeSignal&) = delete;
  NoBrokenPipeSignal& operator=(const NoBrokenPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
  bool was_pending_ = false;
};

int spawn(pid_t& pid, const std::vector<std::string>& command, int in, int out) {
  std::vector<std::string> words = command;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigaddset(&signals, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  const int error = posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// Where memory ends, the system ends this process before the one that started it.
void prefer_for_ending(pid_t process) {
  std::ofstream("/proc/" + std::to_string(process) + "/oom_score_adj") << 1000;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  if (command.empty() || command.front().empty()) reject("engine", "names no program");
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  int error = pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0 ? errno : 0;
  if (error == 0) error = spawn(pid_, command, in[0], out[1]);
  for (const int theirs : {in[0], out[1]})
    if (theirs >= 0) close(theirs);
  to_ = in[1], from_ = out[0];
  if (error == 0) prefer_for_ending(pid_);
  if (error != 0) {
    for (const int ours : {to_, from_})
      if (ours >= 0) close(ours);
    reject("engine " + command.front(), std::string("cannot be started: ") + std::strerror(error));
  }
  for (const int ours : {to_, from_}) {
    fcntl(ours, F_SETFL, O_NONBLOCK);
    fcntl(ours, F_SETPIPE_SZ, kPipeBytes);
  }
}

ChildProcess::~ChildProcess() {
  close(to_);  // a program that reads to the end ends by itself
  end();
  close(from_);
}

bool ChildProcess::write_some(std::string_view& request) const {
  const ssize_t count = write(to_, request.data(), request.size());
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  request.remove_prefix(static_cast<std::size_t>(count));
  return true;
}

bool ChildProcess::read_some(std::string& reply, std::size_t most) const {
  const std::size_t before = reply.size();
  most = std::min<std::size_t>(most, 1 << 16);  // room is filled with zeros first
  reply.resize(before + most);
  const ssize_t count = read(from_, reply.data() + before, most);
  reply.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  return count > 0 || (count < 0 && (errno == EAGAIN || errno == EINTR));
}

ChildProcess::Turn ChildProcess::exchange(std::string_view& request, std::string& reply, std::size_t most,
                                          std::chrono::milliseconds limit) {
  std::array<pollfd, 2> ends{{{from_, POLLIN, 0}, {request.empty() ? -1 : to_, POLLOUT, 0}}};
  const int ready = poll(ends.data(), ends.size(), static_cast<int>(limit.count()));
  if (ready < 0) return errno == EINTR ? Turn::wrote_or_read : Turn::ended;
  if (ready == 0) return Turn::timed_out;
  if (ends[0].revents != 0 && !read_some(reply, most)) return Turn::ended;
  if (ends[1].revents == 0) return Turn::wrote_or_read;
  const NoBrokenPipeSignal quiet;
  return write_some(request) ? Turn::wrote_or_read : Turn::ended;
}

bool ChildProcess::has_more() const {
  pollfd end{from_, POLLIN, 0};
  return poll(&end, 1, 0) > 0 && (end.revents & POLLIN) != 0;
}

bool ChildProcess::is_silent() const {
  pollfd end{from_, POLLIN, 0};
  return poll(&end, 1, 0) == 0;
}

std::string ChildProcess::end() {
  if (pid_ < 0) return "";
  // One that has just closed its pipes is given a moment to end by itself: its signal is the reason.
  bool is_ended = false;
  for (int i = 0; i < 50 && !is_ended; ++i) {
    siginfo_t how{};
    waitid(P_PID, static_cast<id_t>(pid_), &how, WEXITED | WNOHANG | WNOWAIT);
    is_ended = how.si_pid != 0;
    if (!is_ended && has_more()) break;
    if (!is_ended) usleep(1000);
  }
  kill(-pid_, SIGKILL);  // and what it started; before it is waited for, so that the number is still its own
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
  pid_ = -1;
  if (!is_ended) return "";
  if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status));
  return "exit code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace touchstone::process_engine
