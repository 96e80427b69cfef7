#include "touchstone/examples/program/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace touchstone::comparison {

std::atomic<bool> ProgressLine::interrupted{false};

ProgressLine::ProgressLine()
    : terminal_(isatty(STDERR_FILENO) == 1), start_(std::chrono::steady_clock::now()) {}
ProgressLine::~ProgressLine() { finish(); }

void ProgressLine::step(const std::string& what) {
  if (interrupted) throw Interrupted();
  what_ = what;
  if (!terminal_) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    fmt::print(stderr, "[{:6.1f} s] {}\n", elapsed.count(), what_);
  }
  draw(0.0);
}

void ProgressLine::share(double done) {
  if (interrupted) throw Interrupted();
  if (std::chrono::steady_clock::now() - last_ > std::chrono::milliseconds(100)) draw(done);
}

void ProgressLine::draw(double done) {
  last_ = std::chrono::steady_clock::now();
  if (!terminal_) return;
  const std::chrono::duration<double> elapsed = last_ - start_;
  fmt::print(stderr, "\r\033[K{:5.0f} s  {:3.0f} %  {}", elapsed.count(), 100 * done, what_);
  std::fflush(stderr);
}

void ProgressLine::finish() {
  if (terminal_ && !what_.empty()) fmt::print(stderr, "\r\033[K");
  what_.clear();
}

}  // namespace touchstone::comparison
