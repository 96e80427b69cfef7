#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// How far movers get where contacts hold them back, against what small steps find (path_finder.hpp).

namespace touchstone {

struct ProgressRun {
  std::string scene;
  double rate = 50.0;      ///< frames a second
  double gap = 1e-7;       ///< [m]
  std::uint64_t seed = 1;  ///< of the first trial; the next ones count on
  int trials = 1;
  int looks = 20;  ///< frames of a trial for which a path is searched, spread over those that are blocked
};

/// Of one frame, in the mover's own metric.
struct FrozenFrame {
  std::uint64_t seed;  ///< of its trial
  int frame;
  double left;   ///< to the command at its start
  double taken;  ///< by which the frame came nearer
  double found;  ///< and small steps
};

/// A frame is frozen if it comes less than a tenth as much nearer to its command as small steps do, where
/// these come nearer by at least a thousandth of what is left.
struct ProgressFigures {
  ProgressRun run;
  std::uint64_t frames = 0, blocked = 0;
  std::uint64_t motionless = 0;  ///< blocked frames that come no nearer to their command by 1e-6 of it
  std::uint64_t looked_at = 0;   ///< blocked frames for which small steps were searched
  std::uint64_t open = 0;        ///< of these, the ones that had one
  std::uint64_t frozen = 0;      ///< of these, the ones that did not take it
  std::uint64_t stuck = 0;  ///< trials at whose end small steps go on by more than a hundredth of their path
  std::uint64_t merged =
      0;  ///< frames looked at in which two solids touch, by `exact` at samples of each part
  std::vector<FrozenFrame> frozen_frames;
  double worst_us = 0.0;  ///< longest frame
  double sum_us = 0.0;

  double frozen_share() const {
    return open == 0 ? 0.0 : static_cast<double>(frozen) / static_cast<double>(open);
  }
};

/// The scenes' names.
std::span<const std::string_view> progress_scenes();
/// @throws std::invalid_argument: no such scene.
ProgressFigures measure_progress(const ProgressRun& run);

void print_progress_heading(std::ostream& out);
void print_progress(std::ostream& out, const ProgressFigures& figures);
/// One frame a line; none if no frame is frozen.
void print_frozen(std::ostream& out, const ProgressFigures& figures);

}  // namespace touchstone
