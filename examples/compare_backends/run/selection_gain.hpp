#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"

namespace touchstone::comparison {

/// A contact world of boxes that all move and turn, with some of them switched off.
struct SelectionRow {
  std::size_t objects = 0;
  std::size_t switched_off = 0;  ///< objects, evenly spread over the world
  double candidate_pairs = 0;    ///< a frame, mean
  Timing frame;                  ///< [ns]
};

struct SelectionOptions {
  std::uint64_t seed = 1;
  std::size_t objects = 1000;
  std::vector<double> shares_off = {0, 0.5, 0.9, 1};
  std::size_t frames = 20;      ///< flown there and back
  std::size_t repetitions = 5;  ///< of there and back
};

/// Every share in turn, repetition by repetition, so that a machine that slows down slows all of them. The
/// world has native's checks, and reports contacts without stopping at them, so that all fly the same motion.
std::vector<SelectionRow> run_selection(const SelectionOptions& options);

}  // namespace touchstone::comparison
