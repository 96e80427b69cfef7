#include "touchstone/examples/program/terminal/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"

namespace touchstone::program {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

ProgressLine::ProgressLine()
    : terminal_(isatty(own_stderr()) == 1), start_(std::chrono::steady_clock::now()) {}
ProgressLine::~ProgressLine() { finish(); }

void ProgressLine::plan(std::vector<PlannedPart> parts) {
  left_ = TimeLeft(std::move(parts));
  part_start_ = std::chrono::steady_clock::now();
}

void ProgressLine::part_done() {
  left_.finish_part(seconds_since(part_start_));
  part_start_ = std::chrono::steady_clock::now();
}

std::string ProgressLine::whole() const {
  if (left_.finished() == left_.parts()) return "";
  const std::optional<double> left = left_.estimate(seconds_since(part_start_));
  return fmt::format("part {} of {}{}: ", left_.finished() + 1, left_.parts(),
                     left ? ", " + about(*left) + " left" : "");
}

void ProgressLine::step(const std::string& what) {
  stop_if_interrupted();
  what_ = what;
  if (!terminal_) {
    say(fmt::format("[{:6.1f} s] {}{}\n", seconds_since(start_), whole(), what_));
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
  say(fmt::format("\r\033[K{:5.0f} s  {}{:3.0f} %  {}", seconds_since(start_), whole(), 100 * done, what_));
}

void ProgressLine::finish() {
  if (terminal_ && !what_.empty()) say("\r\033[K");
  what_.clear();
}

}  // namespace touchstone::program
