#pragma once

#include <string>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"

namespace touchstone::comparison {

/// A backend's speed and wrong answers in one query, over some sets: what rankings and verdicts order.
struct Standing {
  std::string backend;
  /// Mean over the sets of the median per pair of all their pairs: one pair a call, in scenes a frame a call;
  /// NaN if not measured in all.
  double nanoseconds = 0;
  Wrongness wrong{};
};

}  // namespace touchstone::comparison
