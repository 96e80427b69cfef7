#include "examples/compare_backends/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchstone::comparison {
namespace {

Candidate sum_up(std::span<const SetResult> sets, const std::string& backend, QueryKind query,
                 double max_error) {
  Candidate candidate;
  candidate.backend = backend;
  const std::size_t q = index_of(query);
  for (const SetResult& set : sets) {
    const auto found = std::find_if(set.backends.begin(), set.backends.end(),
                                    [&](const BackendResult& result) { return result.name == backend; });
    const bool judged = found != set.backends.end() && found->judged;
    candidate.nanoseconds += found != set.backends.end() ? verdict_speed(set, *found, query)
                                                         : std::numeric_limits<double>::quiet_NaN();
    const WorstCase worst = judged ? found->judgement.worst[q]
                                   : WorstCase{std::numeric_limits<double>::infinity(), 0, "not measured"};
    if (candidate.worst_id.empty() || worst.cost > candidate.worst_cost) {
      candidate.worst_cost = worst.cost;
      candidate.worst_id = case_id(set, worst.index);
      candidate.worst_reason = worst.reason;
    }
  }
  candidate.nanoseconds /= static_cast<double>(sets.size());
  candidate.inside = candidate.worst_cost <= max_error && std::isfinite(candidate.nanoseconds);
  return candidate;
}

}  // namespace

Verdict decide(std::span<const SetResult> sets, QueryKind query, double max_error) {
  Verdict verdict{query, max_error, {}, {}};
  for (const SetResult& set : sets) {
    for (const BackendResult& backend : set.backends) {
      const bool known =
          std::any_of(verdict.candidates.begin(), verdict.candidates.end(),
                      [&](const Candidate& candidate) { return candidate.backend == backend.name; });
      if (!known) verdict.candidates.push_back(sum_up(sets, backend.name, query, max_error));
    }
  }
  std::stable_sort(verdict.candidates.begin(), verdict.candidates.end(),
                   [](const Candidate& x, const Candidate& y) {
                     if (x.inside != y.inside) return x.inside;
                     return x.inside ? x.nanoseconds < y.nanoseconds : x.worst_cost < y.worst_cost;
                   });
  if (!verdict.candidates.empty() && verdict.candidates.front().inside) {
    verdict.fastest = verdict.candidates.front().backend;
  }
  return verdict;
}

std::string sentence(const Verdict& verdict) {
  const std::string asked =
      fmt::format("within {:.3g} m on every {} case", verdict.max_error, to_string(verdict.query));
  if (verdict.fastest.empty()) return "no backend stays " + asked;
  return fmt::format("fastest {}: {}, {:.0f} ns a pair", asked, verdict.fastest,
                     verdict.candidates.front().nanoseconds);
}

}  // namespace touchstone::comparison
