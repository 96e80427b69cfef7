#include "touchstone/examples/program/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "touchstone/examples/program/engine_log.hpp"
#include "touchstone/examples/program/interruption.hpp"

namespace touchstone::comparison {

ProgressLine::ProgressLine()
    : terminal_(isatty(own_stderr()) == 1), start_(std::chrono::steady_clock::now()) {}
ProgressLine::~ProgressLine() { finish(); }

void ProgressLine::step(const std::string& what) {
  stop_if_interrupted();
  what_ = what;
  if (!terminal_) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    say(fmt::format("[{:6.1f} s] {}\n", elapsed.count(), what_));
  }
  draw(0.0);
}

void ProgressLine::share(double done) {
  stop_if_interrupted();
  if (std::chrono::steady_clock::now() - last_ > std::chrono::milliseconds(100)) draw(done);
}

void ProgressLine::draw(double done) {
  last_ = std::chrono::steady_clock::now();
  if (!terminal_) return;
  const std::chrono::duration<double> elapsed = last_ - start_;
  say(fmt::format("\r\033[K{:5.0f} s  {:3.0f} %  {}", elapsed.count(), 100 * done, what_));
}

void ProgressLine::finish() {
  if (terminal_ && !what_.empty()) say("\r\033[K");
  what_.clear();
}

}  // namespace touchstone::comparison
