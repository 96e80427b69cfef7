#pragma once

#include <span>
#include <vector>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"
#include "touchstone/examples/compare_backends/judge/standing.hpp"

namespace touchstone::comparison {

/// A backend's standing over all sets of a run, whatever their scale.
struct RankedBackend : Standing {
  double worst_error = 0;  ///< largest cost over S; +inf for a missing figure
};

/// The order where no error was named; with one, see Verdict. First the backends without a wrong or missing
/// answer, by speed; then the others, by the number of such answers.
struct Ranking {
  QueryKind query = QueryKind::distance;
  std::vector<RankedBackend> standings;
};
Ranking rank(std::span<const SetResult> sets, QueryKind query);

}  // namespace touchstone::comparison
