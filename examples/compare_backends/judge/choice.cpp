#include "touchstone/examples/compare_backends/judge/choice.hpp"

#include <algorithm>
#include <map>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::comparison {
namespace {

double p999_of(const BackendResult& backend, std::size_t q) {
  const std::optional<Timing>& timing = backend.rows[q].single ? backend.rows[q].single : backend.frame[q];
  return timing ? timing->p999_ns : kNaN;
}

// Each id once, in the order in which it is first named.
class IdTable {
 public:
  explicit IdTable(std::vector<std::string>& ids) : ids_(ids) {}
  std::size_t index_of(const std::string& id) {
    const auto [found, is_new] = places_.emplace(id, ids_.size());
    if (is_new) ids_.push_back(id);
    return found->second;
  }

 private:
  std::vector<std::string>& ids_;
  std::map<std::string, std::size_t> places_;
};

CostCurves with_ids(CostCurves curves, const SetResult& set, IdTable& ids) {
  for (StratumCosts& stratum : curves) {
    for (AskedCosts& asked : stratum.asked)
      asked.worst_index = asked.worst_code == 0 ? 0 : ids.index_of(case_id(set, asked.worst_index));
  }
  return curves;
}

ChoiceSet choice_set(const SetResult& set) {
  ChoiceSet result;
  result.name = set.name;
  result.cases = set.cases;
  IdTable ids(result.ids);
  for (const BackendResult& backend : set.backends) {
    if (!backend.judged) continue;
    ChoiceSet::Backend& shown = result.backends.emplace_back();
    shown.name = backend.name;
    for (const QueryKind kind : kQueryKinds) {
      const std::size_t q = index_of(kind);
      shown.queries[q] = {verdict_speed(set, backend, kind), p999_of(backend, q),
                          backend.rows[q].allocations.value_or(kNaN),
                          with_ids(backend.judgement.curves[q], set, ids)};
    }
  }
  return result;
}

const std::map<std::string, QueryKind> kQueries = {
    {"overlap", QueryKind::overlap}, {"distance", QueryKind::distance}, {"manifold", QueryKind::manifold}};

}  // namespace

bool Choice::has(const Stratum& stratum) const {
  if (stratum.within_bin > bin_of(within, kWithinBins)) return false;
  switch (stratum.band) {
    case Band::apart:
      return apart && stratum.apart_bin <= bin_of(apart_up_to, kApartBins);
    case Band::touching:
      return touching;
    case Band::deep:
      return deep;
  }
  return false;
}

bool Choice::has_set(const std::string& name) const {
  return sets.empty() || std::find(sets.begin(), sets.end(), name) != sets.end();
}

double upper_end(double limit, std::span<const double> bins) {
  const std::size_t bin = bin_of(limit, bins);
  return bin < bins.size() ? bins[bin] : kInfinity;
}

std::vector<ChoiceSet> choice_sets(std::span<const SetResult> sets) {
  std::vector<ChoiceSet> result;
  for (const SetResult& set : sets) {
    ChoiceSet each = choice_set(set);
    if (!each.backends.empty()) result.push_back(std::move(each));
  }
  return result;
}

std::size_t cases_in(const ChoiceSet& set, const Choice& choice) {
  if (!choice.has_set(set.name) || set.backends.empty()) return 0;
  std::size_t cases = 0;
  for (const StratumCosts& each : set.backends.front().queries[index_of(choice.query)].curves) {
    if (choice.has(each.stratum)) cases += each.cases;
  }
  return cases;
}

void check_sets(const Choice& choice, const std::vector<std::string>& known) {
  for (const std::string& name : choice.sets) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("--of: no set '" + name + "'; there are " + joined(known));
  }
}

QueryKind query_named(const std::string& name) {
  const auto found = kQueries.find(name);
  if (found == kQueries.end()) throw InputError("unknown query '" + name + "'");
  return found->second;
}

}  // namespace touchstone::comparison
