#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "touchstone/examples/program/terminal/time_left.hpp"

namespace touchstone::program {

/// Progress on stderr: one line that updates itself on a terminal, else a plain line for each step. No call
/// returns once a signal has come: what is left of the processor is the answer's, see interruption.hpp.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  /// The parts of the whole: the line then names the part that runs and the time that the rest takes.
  void plan(std::vector<PlannedPart> parts);
  void part_done();
  void step(const std::string& what);
  void share(double done);  ///< of the step, 0 to 1
  void finish();

 private:
  void draw(double done);
  std::string whole() const;
  bool terminal_;
  std::string what_;
  TimeLeft left_;
  std::chrono::steady_clock::time_point start_, last_, part_start_;
};

}  // namespace touchstone::program
