#pragma once

#include <optional>
#include <string>
#include <vector>

namespace touchstone::program {

/// A part of a run. Parts of one kind take time in proportion to their size; sizes of all kinds are in one
/// unit.
struct PlannedPart {
  std::string kind;
  double size;
};

/// How long a run still takes, by what its parts took so far.
class TimeLeft {
 public:
  explicit TimeLeft(std::vector<PlannedPart> parts = {}) : parts_(std::move(parts)) {}

  /// The part that is running is done: `seconds` after it began.
  void finish_part(double seconds);

  std::size_t finished() const { return seconds_.size(); }
  std::size_t parts() const { return parts_.size(); }

  /// @param running seconds since the running part began. A kind of which no part is done is taken to be as
  /// fast as the others. Nothing before any part is done.
  std::optional<double> estimate(double running) const;

 private:
  double pace_of(const std::string& kind) const;  // seconds per size
  std::vector<PlannedPart> parts_;
  std::vector<double> seconds_;  // of the finished ones
};

/// "about 40 s", "about 12 min": rounded as far as an estimate is good for.
std::string about(double seconds);

}  // namespace touchstone::program
