#pragma once

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>

namespace touchstone::comparison {

/// Thrown at the next progress call after SIGINT or SIGTERM.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted: no report was written") {}
};

/// Progress on stderr: one line that updates itself on a terminal, else a plain line for each step.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  void step(const std::string& what);  ///< @throws Interrupted
  void share(double done);             ///< of the step, 0 to 1. @throws Interrupted
  void finish();

  /// Set from the signal handler.
  static std::atomic<bool> interrupted;

 private:
  void draw(double done);
  bool terminal_;
  std::string what_;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace touchstone::comparison
