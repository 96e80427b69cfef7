#pragma once

#include <cstddef>
#include <vector>

#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/tests/benchmarks/motion/arm_flight.hpp"

// What a frame of a sliding arm costs at least: parts of it that no way of finding the slide does without.

namespace touchstone {

/// A flight's frames once it has settled: where the arm was, what it was commanded, where it went [rad].
struct FlownFrame {
  std::vector<double> from, commanded, to;
};
std::vector<FlownFrame> fly_and_note(const ArmCase& wanted, std::size_t frames);

/// Frames in which the world is commanded to where the flight went: it has to prove the motion that is
/// executed, and to find nothing.
struct ToldFrames {
  std::vector<double> us;  ///< of each frame without a sub-step the least of the flights
  double queries = 0.0;    ///< narrowphase calls a frame, of all
  double steps = 0.0;  ///< sub-steps of slides a frame, of all: where rounding stopped the motion after all
};
ToldFrames fly_as_told(const ArmCase& wanted, const std::vector<FlownFrame>& flown, int flights);

/// What an engine's own sweep takes for the same frames.
struct SweptFrames {
  std::vector<double> us;  ///< of all sweeps of a frame, the least of three rounds
  double sweeps = 0.0;     ///< a frame
  double meetings = 0.0;   ///< share of frames in which one meets anything
};

/// Sweeps each solid of the arm against each block, where the boxes about both meet on the way to the
/// command. Poses at both ends are the arm's; between them the engine turns solids evenly. Searching for
/// these pairs and setting them is not timed.
SweptFrames sweep(const ArmCase& wanted, const std::vector<FlownFrame>& flown, const SweepEntry& entry);

}  // namespace touchstone
