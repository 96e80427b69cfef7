#include "touchstone/examples/compare_backends/run/scenes/frame_answer.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::comparison {

FrameAnswer frame_answer(const QueryAnswers& answers, std::size_t frame, std::size_t pairs) {
  FrameAnswer result;
  for (std::size_t i = frame * pairs; i < (frame + 1) * pairs; ++i) {
    result.contact |= answers.status[i] == PairStatus::overlapping;
    const bool decided =
        answers.status[i] == PairStatus::overlapping || answers.status[i] == PairStatus::separated;
    result.unsure |= !decided;
    if (answers.geometry.empty()) continue;
    const double separation = answers.geometry[i].separation;
    if (std::isnan(separation) || std::isnan(result.least)) {
      result.least = kNaN;
    } else {
      result.least = std::min(result.least, separation);
    }
  }
  return result;
}

}  // namespace touchstone::comparison
