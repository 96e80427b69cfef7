#pragma once

#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// A backend's results over all sets, in one query.
struct Standing {
  std::string backend;
  /// Mean over the sets of the median per pair, one pair a call; NaN if not measured in all.
  double nanoseconds = 0;
  double worst_error = 0;  ///< largest cost over S; +inf for a missing figure
  Wrongness wrongness;     ///< summed over the sets
};

/// Ranks the backends without a wrong or missing answer by speed, then the others by their number.
struct Ranking {
  QueryKind query = QueryKind::distance;
  std::vector<Standing> standings;
};
Ranking rank(std::span<const SetResult> sets, QueryKind query);

}  // namespace touchstone::comparison
