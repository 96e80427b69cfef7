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

void add(Wrongness& sum, const Wrongness& more) {
  sum.cases += more.cases;
  sum.missed += more.missed;
  sum.phantom += more.phantom;
  sum.undecided += more.undecided;
  sum.failed += more.failed;
  sum.unsupported += more.unsupported;
  sum.missing += more.missing;
}

Standing stand(std::span<const SetResult> sets, const std::string& backend, QueryKind query) {
  Standing standing{backend, 0, 0, {}};
  for (const SetResult& set : sets) {
    for (const BackendResult& result : set.backends) {
      if (result.name != backend) continue;
      standing.nanoseconds += verdict_speed(set, result, query) / static_cast<double>(sets.size());
      standing.worst_error = std::max(standing.worst_error, result.judgement.cost[index_of(query)].worst);
      add(standing.wrongness, result.judgement.wrongness[index_of(query)]);
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
                     const std::size_t wrong_x = x.wrongness.total(), wrong_y = y.wrongness.total();
                     if (wrong_x != wrong_y) return wrong_x < wrong_y;
                     if (wrong_x != 0 || std::isnan(x.nanoseconds)) return false;
                     return std::isnan(y.nanoseconds) || x.nanoseconds < y.nanoseconds;
                   });
  return ranking;
}

std::vector<std::string> pareto_front(const SetResult& set, QueryKind query) {
  struct Point {
    double error, ns;
    std::string name;
  };
  std::vector<Point> points;
  const std::size_t q = index_of(query);
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged || backend.judgement.wrongness[q].total() > 0 || !backend.rows[q].single) continue;
    points.push_back({backend.judgement.cost[q].worst, backend.rows[q].single->median_ns, backend.name});
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& x, const Point& y) {
    return x.error < y.error || (x.error == y.error && x.ns < y.ns);
  });
  std::vector<std::string> front;
  double fastest = std::numeric_limits<double>::infinity();
  for (const Point& point : points) {
    if (point.ns >= fastest) continue;
    fastest = point.ns;
    front.push_back(point.name);
  }
  return front;
}

std::string case_id(const SetResult& set, std::size_t index) {
  return set.ids.empty() ? set.name + ":" + std::to_string(index) : set.ids[index];
}

double verdict_speed(const SetResult& set, const BackendResult& backend, QueryKind query) {
  const std::size_t q = index_of(query);
  if (backend.rows[q].single) return backend.rows[q].single->median_ns;
  if (backend.frame[q]) return backend.frame[q]->median_ns / static_cast<double>(set.pairs);
  return std::numeric_limits<double>::quiet_NaN();
}

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
