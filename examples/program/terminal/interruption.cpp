#include "touchstone/examples/program/terminal/interruption.hpp"

#include <semaphore.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <limits>
#include <thread>

#include "touchstone/examples/program/terminal/engine_log.hpp"

namespace touchstone::program {
namespace {

using Answers = std::list<std::function<std::string()>>;

// Never destroyed: the thread outlives main().
std::recursive_mutex& mutex() {
  static auto* const mutex = new std::recursive_mutex;
  return *mutex;
}
Answers& answers() {
  static auto* const answers = new Answers;
  return *answers;
}

std::atomic<int> first_signal{0};
// A second signal may come before the first has written its time; it does not count as one of a later second
// then.
std::atomic<long long> first_ms{std::numeric_limits<long long>::max()};
sem_t woken;

constexpr long long kPatience = 1000;  // [ms]

long long now_ms() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1000LL * now.tv_sec + now.tv_nsec / 1000000;
}

/// Calls only what a handler may. `timeout` and terminals send a signal twice: a second one within the time
/// of the answer is the same one, a later one means it.
void on_signal(int signal) {
  int none = 0;
  if (first_signal.compare_exchange_strong(none, signal)) {
    first_ms = now_ms();
    sem_post(&woken);
  } else if (now_ms() - first_ms > kPatience) {
    _exit(128 + signal);
  }
}

/// Writes out all that was printed so far, unless a thread is stuck in printing.
void flush_output() {
  if (ftrylockfile(stdout) != 0) return;
  fflush_unlocked(stdout);
}

[[noreturn]] void wait_and_answer(const std::string& name) {
  while (sem_wait(&woken) != 0) {
  }
  const std::unique_lock<std::recursive_mutex> hold(mutex());
  for (auto answer = answers().rbegin(); answer != answers().rend(); ++answer) {
    std::string text;
    try {
      text = (*answer)();
    } catch (const std::exception& error) {
      text = error.what();
    }
    // Past the streams, which a thread that is stuck may hold.
    if (!text.empty()) say((isatty(own_stderr()) == 1 ? "\r\033[K" : "") + name + ": " + text + "\n");
  }
  flush_output();
  _exit(128 + first_signal);
}

}  // namespace

void answer_signals(const std::string& name) {
  sem_init(&woken, 0, 0);
  std::thread(wait_and_answer, name).detach();
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

std::unique_lock<std::recursive_mutex> hold_interrupts() {
  return std::unique_lock<std::recursive_mutex>(mutex());
}

void stop_if_interrupted() {
  while (first_signal != 0) pause();
}

OnInterrupt::OnInterrupt(std::function<std::string()> answer) {
  const auto hold = hold_interrupts();
  place_ = answers().insert(answers().end(), std::move(answer));
}
OnInterrupt::~OnInterrupt() {
  const auto hold = hold_interrupts();
  answers().erase(place_);
}

}  // namespace touchstone::program
