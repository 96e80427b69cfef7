#include "touchstone/examples/program/terminal/time_left.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace touchstone::program {

void TimeLeft::finish_part(double seconds) {
  if (seconds_.size() < parts_.size()) seconds_.push_back(seconds);
}

double TimeLeft::pace_of(const std::string& kind) const {
  double seconds = 0.0, size = 0.0, all_seconds = 0.0, all_size = 0.0;
  for (std::size_t i = 0; i < seconds_.size(); ++i) {
    all_seconds += seconds_[i], all_size += parts_[i].size;
    if (parts_[i].kind == kind) seconds += seconds_[i], size += parts_[i].size;
  }
  if (size > 0.0) return seconds / size;
  return all_size > 0.0 ? all_seconds / all_size : 0.0;
}

std::optional<double> TimeLeft::estimate(double running) const {
  if (seconds_.empty() || seconds_.size() == parts_.size()) return std::nullopt;
  const PlannedPart& current = parts_[seconds_.size()];
  double left = std::max(0.0, pace_of(current.kind) * current.size - running);
  for (std::size_t i = seconds_.size() + 1; i < parts_.size(); ++i)
    left += pace_of(parts_[i].kind) * parts_[i].size;
  return left;
}

std::string about(double seconds) {
  if (seconds < 90.0) return fmt::format("about {:.0f} s", 10.0 * std::ceil(seconds / 10.0));
  return fmt::format("about {:.0f} min", std::ceil(seconds / 60.0));
}

}  // namespace touchstone::program
