#pragma once

#include <span>
#include <string>
#include <vector>

#include "examples/compare_backends/set_result.hpp"

namespace touchstone::comparison {

/// How a backend stands over all sets for one query.
struct Candidate {
  std::string backend;
  /// Mean over the sets of the median per pair: one pair a call, in scenes a frame a call; NaN if not
  /// measured in all.
  double nanoseconds = 0;
  double worst_cost = 0;  ///< [m]
  std::string worst_id;
  std::string worst_reason;
  bool inside = false;  ///< worst_cost <= max_error, and the speed was measured
};

struct Verdict {
  QueryKind query = QueryKind::distance;
  double max_error = 0;               ///< [m]
  std::string fastest;                ///< empty: none stays inside
  std::vector<Candidate> candidates;  ///< the ones inside by speed, then the others by cost
};

Verdict decide(std::span<const SetResult> sets, QueryKind query, double max_error);

/// "fastest within 1e-06 m on every distance case: native, 41 ns a pair" or that no backend stays within.
std::string sentence(const Verdict& verdict);

}  // namespace touchstone::comparison
