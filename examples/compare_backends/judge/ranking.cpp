#include "touchstone/examples/compare_backends/judge/ranking.hpp"

#include <algorithm>
#include <cmath>

namespace touchstone::comparison {
namespace {

RankedBackend stand(std::span<const SetResult> sets, const std::string& backend, QueryKind query) {
  RankedBackend standing{{.backend = backend}};
  for (const SetResult& set : sets) {
    for (const BackendResult& result : set.backends) {
      if (result.name != backend) continue;
      standing.nanoseconds += verdict_speed(set, result, query) / static_cast<double>(sets.size());
      standing.worst_error = std::max(standing.worst_error, result.judgement.cost[index_of(query)].worst);
      standing.wrong += result.judgement.wrongness[index_of(query)];
    }
  }
  return standing;
}

}  // namespace

Ranking rank(std::span<const SetResult> sets, QueryKind query) {
  Ranking ranking{query, {}};
  for (const SetResult& set : sets.first(sets.empty() ? 0 : 1)) {
    for (const BackendResult& backend : set.backends)
      ranking.standings.push_back(stand(sets, backend.name, query));
  }
  std::stable_sort(ranking.standings.begin(), ranking.standings.end(),
                   [](const Standing& x, const Standing& y) {
                     const bool right_x = x.wrong.is_complete(), right_y = y.wrong.is_complete();
                     if (right_x != right_y) return right_x;
                     const std::size_t wrong_x = x.wrong.total(), wrong_y = y.wrong.total();
                     if (wrong_x != wrong_y) return wrong_x < wrong_y;
                     if (!right_x || std::isnan(x.nanoseconds)) return false;
                     return std::isnan(y.nanoseconds) || x.nanoseconds < y.nanoseconds;
                   });
  return ranking;
}

}  // namespace touchstone::comparison
