#pragma once

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"

namespace touchstone::comparison {

/// A backend's answer for a whole frame: the union of its pairs' answers.
struct FrameAnswer {
  bool contact = false;  ///< some pair overlaps
  bool unsure = false;   ///< some pair is undecided, failed or unsupported
  /// Least separation [m]; NaN when some pair's is missing.
  double least = kInfinity;
};
FrameAnswer frame_answer(const QueryAnswers& answers, std::size_t frame, std::size_t pairs);

}  // namespace touchstone::comparison
