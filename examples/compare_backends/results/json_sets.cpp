#include <cmath>

#include "touchstone/examples/compare_backends/judge/pareto_front.hpp"
#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/results/json_parts.hpp"

namespace touchstone::comparison {
namespace {

using comparison::json;

Json repetition_medians(const Timing& timing) {
  Json list = Json::array();
  for (std::size_t r = 0; r < timing.repetitions; ++r) list.push_back(number(timing.repetition_ns[r]));
  return list;
}

Json json(const Quantiles& quantiles, const SetResult& set) {
  if (quantiles.count == 0) return nullptr;
  return {{"median", number(quantiles.median)},
          {"p99", number(quantiles.p99)},
          {"worst", number(quantiles.worst)},
          {"worst_case", case_id(set, quantiles.worst_case)},
          {"cases", quantiles.count}};
}

Json json(const Capabilities& capabilities) {
  return {{"distance", capabilities.distance},
          {"penetration", capabilities.penetration},
          {"manifold", capabilities.manifold},
          {"overlap_complete", capabilities.overlap_complete},
          {"scalar_bits", capabilities.scalar_bits},
          {"deterministic", capabilities.deterministic},
          {"thread_safe", capabilities.thread_safe},
          {"resolution",
           {{"absolute_m", number(capabilities.resolution.absolute)},
            {"relative", number(capabilities.resolution.relative)}}}};
}

Json json(const WorstCase& worst, const SetResult& set) {
  return {{"cost_m", number(worst.cost)},
          {"case", case_id(set, worst.index)},
          {"reason", worst.reason},
          {"status", to_string(worst.status)},
          {"separation_m", number(worst.separation)},
          {"normal", program::json(worst.n_AB_W)}};
}

Json json_query(const SetResult& set, const BackendResult& backend, QueryKind kind) {
  const std::size_t q = index_of(kind);
  const BackendResult::Rows& rows = backend.rows[q];
  Json result = {{"single", json(rows.single)},
                 {"batch", json(rows.batch)},
                 {"raw", json(rows.raw)},
                 {"cached", json(rows.cached)},
                 {"frame", json(backend.frame[q])},
                 {"allocations_per_query", rows.allocations ? number(*rows.allocations) : Json(nullptr)}};
  if (!backend.judged) return result;
  const WorstCase& worst = backend.judgement.worst[q];
  result["wrong"] = json(backend.judgement.wrongness[q]);
  result["cost_over_S"] = json(backend.judgement.cost[q], set);
  result["cost_curve_over_S"] = Json::array();
  for (const double value : backend.judgement.cost_curve[q])
    result["cost_curve_over_S"].push_back(number(value));
  result["worst"] = json(worst, set);
  result["wrong_cases"] = Json::array();
  for (const WorstCase& wrong : backend.judgement.wrong_cases[q])
    result["wrong_cases"].push_back(json(wrong, set));
  return result;
}

Json json(const Change& change) {
  return {{"cases", change.cases},
          {"classes_changed", change.classes},
          {"bits_changed", change.bits},
          {"left_out", change.left_out},
          {"worst_over_S", number(change.worst)}};
}

Json json(const std::vector<SignedError>& errors, const SetResult& set) {
  Json list = Json::array();
  for (const SignedError& each : errors)
    list.push_back({number(each.separation), number(each.error), case_id(set, each.index)});
  return list;
}

Json json(const SetResult& set, const BackendResult& backend) {
  Json result = {{"backend", backend.name}, {"capabilities", json(backend.capabilities)}};
  if (!backend.failure.empty()) result["failure"] = backend.failure;
  for (const QueryKind kind : kQueryKinds)
    result["queries"][to_string(kind)] = json_query(set, backend, kind);
  result["consistency"] = json(backend.consistency);
  if (!backend.judged) return result;
  result["signed_errors_over_S"] = json(backend.judgement.signed_errors, set);
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const auto measure = static_cast<Measure>(m);
    const ErrorStats& stats = backend.judgement.errors[m];
    if (is_length(measure)) {
      result["errors"][to_string(measure)] = {{"over_S", json(stats.over_scale, set)},
                                              {"over_size", json(stats.over_size, set)}};
    } else {
      result["errors"][to_string(measure)] = {{"ratio", json(stats.over_scale, set)}};
    }
  }
  return result;
}

}  // namespace

Json optional_number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json json(const std::optional<Timing>& timing) {
  if (!timing) return nullptr;
  return {{"median_ns", number(timing->median_ns)},
          {"p99_ns", number(shown_p99(*timing))},
          {"minimum_ns", number(timing->minimum_ns)},
          {"lower_quartile_ns", number(timing->lower_quartile_ns)},
          {"upper_quartile_ns", number(timing->upper_quartile_ns)},
          {"repetition_medians_ns", repetition_medians(*timing)},
          {"p999_ns", number(timing->p999_ns)},
          {"calls", timing->calls},
          {"blocks", timing->blocks},
          {"pairs_a_block", timing->block == 0 ? Json(nullptr) : Json(timing->block)}};
}

Json json(const Wrongness& wrongness) {
  return {{"cases", wrongness.cases},
          {"missed", wrongness.missed},
          {"phantom", wrongness.phantom},
          {"undecided", wrongness.undecided},
          {"failed", wrongness.failed},
          {"unsupported", wrongness.unsupported},
          {"missing_value", wrongness.missing},
          {"share_below_95",
           {{"any", number(upper_bound_95(wrongness.total(), wrongness.supported()))},
            {"missed", number(upper_bound_95(wrongness.missed, wrongness.supported()))},
            {"phantom", number(upper_bound_95(wrongness.phantom, wrongness.supported()))},
            {"undecided", number(upper_bound_95(wrongness.undecided, wrongness.supported()))},
            {"failed", number(upper_bound_95(wrongness.failed, wrongness.supported()))},
            {"unsupported", number(upper_bound_95(wrongness.unsupported, wrongness.cases))},
            {"missing_value", number(upper_bound_95(wrongness.missing, wrongness.supported()))}}}};
}

Json json(const std::optional<Consistency>& consistency) {
  if (!consistency) return nullptr;
  return {{"swapped", json(consistency->swapped)},
          {"moved", json(consistency->moved)},
          {"repeated", json(consistency->repeated)},
          {"threads", json(consistency->threads)}};
}

Json json(const SetResult& set) {
  Json result = {{"name", set.name},         {"description", set.description}, {"cases", set.cases},
                 {"contacts", set.contacts}, {"touching", set.touching},       {"backends", Json::array()}};
  for (const BackendResult& backend : set.backends) result["backends"].push_back(json(set, backend));
  for (const QueryKind kind : kQueryKinds) result["pareto_front"][to_string(kind)] = pareto_front(set, kind);
  return result;
}

}  // namespace touchstone::comparison
