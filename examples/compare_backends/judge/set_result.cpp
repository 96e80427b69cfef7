#include "touchstone/examples/compare_backends/judge/set_result.hpp"

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::comparison {
Consistency total_consistency(std::span<const SetResult> sets, const std::string& backend) {
  Consistency sum;
  for (const SetResult& set : sets) {
    for (const BackendResult& result : set.backends) {
      if (result.name != backend || !result.consistency) continue;
      sum.swapped += result.consistency->swapped;
      sum.moved += result.consistency->moved;
      sum.repeated += result.consistency->repeated;
      sum.threads += result.consistency->threads;
    }
  }
  return sum;
}

std::string case_id(const SetResult& set, std::size_t index) {
  return set.ids.empty() ? set.name + ":" + std::to_string(index) : set.ids[index];
}

double verdict_speed(const SetResult& set, const BackendResult& backend, QueryKind query) {
  const std::size_t q = index_of(query);
  if (backend.rows[q].single) return backend.rows[q].single->median_ns;
  if (backend.frame[q]) return backend.frame[q]->median_ns / static_cast<double>(set.pairs);
  return kNaN;
}

}  // namespace touchstone::comparison
