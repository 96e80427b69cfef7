#pragma once

#include <chrono>
#include <string>

namespace touchstone::comparison {

/// Progress on stderr: one line that updates itself on a terminal, else a plain line for each step. No call
/// returns once a signal has come: what is left of the processor is the answer's, see interruption.hpp.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  void step(const std::string& what);
  void share(double done);  ///< of the step, 0 to 1
  void finish();

 private:
  void draw(double done);
  bool terminal_;
  std::string what_;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace touchstone::comparison
