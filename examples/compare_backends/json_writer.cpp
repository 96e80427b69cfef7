#include "examples/compare_backends/json_writer.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "examples/compare_backends/method_text.hpp"
#include "examples/compare_backends/pareto_front.hpp"

namespace touchstone::comparison {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json json(const std::optional<Timing>& timing) {
  if (!timing) return nullptr;
  return {{"median_ns", number(timing->median_ns)},
          {"p99_ns", number(timing->p99_ns)},
          {"minimum_ns", number(timing->minimum_ns)},
          {"blocks", timing->blocks},
          {"pairs_a_block", timing->block == 0 ? Json(nullptr) : Json(timing->block)}};
}

Json json(const Quantiles& quantiles, const SetResult& set) {
  if (quantiles.count == 0) return nullptr;
  return {{"median", number(quantiles.median)},
          {"p99", number(quantiles.p99)},
          {"worst", number(quantiles.worst)},
          {"worst_case", case_id(set, quantiles.worst_case)},
          {"cases", quantiles.count}};
}

Json json(const Wrongness& wrongness) {
  return {{"cases", wrongness.cases},          {"missed", wrongness.missed},
          {"phantom", wrongness.phantom},      {"undecided", wrongness.undecided},
          {"failed", wrongness.failed},        {"unsupported", wrongness.unsupported},
          {"missing_value", wrongness.missing}};
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

Json json_query(const SetResult& set, const BackendResult& backend, QueryKind kind) {
  const std::size_t q = index_of(kind);
  const BackendResult::Rows& rows = backend.rows[q];
  Json result = {{"single", json(rows.single)},
                 {"batch", json(rows.batch)},
                 {"raw", json(rows.raw)},
                 {"frame", json(backend.frame[q])},
                 {"allocations_per_query", rows.allocations ? number(*rows.allocations) : Json(nullptr)}};
  if (!backend.judged) return result;
  const WorstCase& worst = backend.judgement.worst[q];
  result["wrong"] = json(backend.judgement.wrongness[q]);
  result["cost_over_S"] = json(backend.judgement.cost[q], set);
  result["worst"] = {
      {"cost_m", number(worst.cost)}, {"case", case_id(set, worst.index)}, {"reason", worst.reason}};
  return result;
}

Json json(const SetResult& set, const BackendResult& backend) {
  Json result = {{"backend", backend.name}, {"capabilities", json(backend.capabilities)}};
  if (!backend.failure.empty()) result["failure"] = backend.failure;
  for (const QueryKind kind : kQueryKinds)
    result["queries"][to_string(kind)] = json_query(set, backend, kind);
  if (!backend.judged) return result;
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

Json json(const SetResult& set) {
  Json result = {{"name", set.name},         {"description", set.description}, {"cases", set.cases},
                 {"contacts", set.contacts}, {"touching", set.touching},       {"backends", Json::array()}};
  for (const BackendResult& backend : set.backends) result["backends"].push_back(json(set, backend));
  for (const QueryKind kind : kQueryKinds) result["pareto_front"][to_string(kind)] = pareto_front(set, kind);
  return result;
}

Json json(const BroadphaseResult& result) {
  Json json = {{"broadphase", result.name},
               {"description", result.description},
               {"objects", result.size.objects},
               {"hexahedra_each", result.size.hexahedra_each}};
  if (!result.gap.empty()) {
    json["gap"] = result.gap;
    return json;
  }
  json["frames"] = result.frames;
  json["frame_ms"] = {{"median", number(result.frame.median_ns * 1e-6)},
                      {"p99", number(result.frame.p99_ns * 1e-6)},
                      {"minimum", number(result.frame.minimum_ns * 1e-6)}};
  json["with_overlap_ms"] =
      result.with_overlap ? number(result.with_overlap->median_ns * 1e-6) : Json(nullptr);
  json["candidates_per_frame"] = number(result.candidates);
  json["allocations_per_frame"] = result.allocations ? number(*result.allocations) : Json(nullptr);
  json["missed"] = result.missed ? Json(*result.missed) : Json(nullptr);
  json["true_pairs"] = result.missed ? Json(result.true_pairs) : Json(nullptr);
  json["true_pairs_from"] = result.missed
                                ? Json(result.from_candidates ? "all broadphases' candidates" : "all pairs")
                                : Json(nullptr);
  return json;
}

Json optional_number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json json(const SceneResult& scene) {
  Json result = {{"name", scene.name},
                 {"file", scene.file},
                 {"rate_hz", number(scene.rate)},
                 {"duration_s", number(scene.duration)},
                 {"gap_m", number(scene.gap)},
                 {"parameters", scene.parameters},
                 {"frames", scene.frames},
                 {"frames_of_the_scene", scene.all_frames},
                 {"pairs", scene.pairs},
                 {"exact_first_contact_s", optional_number(scene.exact_first_contact)},
                 {"backends", Json::array()},
                 {"cases", json(scene.set)}};
  for (const SceneBackend& backend : scene.backends) {
    result["backends"].push_back({{"backend", backend.name},
                                  {"first_contact_s", optional_number(backend.first_contact)},
                                  {"missed_frames", backend.missed_frames},
                                  {"phantom_frames", backend.phantom_frames},
                                  {"undecided_frames", backend.undecided_frames},
                                  {"worst_clearance_error_m", number(backend.worst_clearance_error)}});
  }
  if (scene.facet_rows.empty()) return result;
  result["facets"] = {{"finest", scene.finest_facets},
                      {"frames", scene.facet_frames},
                      {"budget_m", number(scene.facet_budget)},
                      {"rows", Json::array()}};
  for (const FacetRow& row : scene.facet_rows) {
    result["facets"]["rows"].push_back({{"backend", row.backend},
                                        {"facets", row.facets},
                                        {"query", to_string(row.query)},
                                        {"pairs", row.pairs},
                                        {"frame_ns", number(row.frame_ns)},
                                        {"error_m", number(row.error)},
                                        {"serves", row.serves}});
  }
  for (const QueryKind query : kQueryKinds) {
    const FacetRow* cheapest = cheapest_row(scene, query);
    result["facets"]["least_that_serves"][to_string(query)] =
        cheapest ? Json{{"backend", cheapest->backend}, {"facets", cheapest->facets}} : Json(nullptr);
  }
  return result;
}

Json json(const Verdict& verdict) {
  Json result = {{"query", to_string(verdict.query)},
                 {"max_error_m", number(verdict.max_error)},
                 {"fastest", verdict.fastest.empty() ? Json(nullptr) : Json(verdict.fastest)},
                 {"sentence", sentence(verdict)},
                 {"candidates", Json::array()}};
  for (const Candidate& candidate : verdict.candidates) {
    result["candidates"].push_back({{"backend", candidate.backend},
                                    {"inside", candidate.inside},
                                    {"mean_ns", number(candidate.nanoseconds)},
                                    {"worst_cost_m", number(candidate.worst_cost)},
                                    {"worst_case", candidate.worst_id},
                                    {"worst_reason", candidate.worst_reason}});
  }
  return result;
}

Json json(const Ranking& ranking) {
  Json result = {{"query", to_string(ranking.query)}, {"standings", Json::array()}};
  for (const Standing& standing : ranking.standings) {
    result["standings"].push_back({{"backend", standing.backend},
                                   {"mean_ns", number(standing.nanoseconds)},
                                   {"worst_cost_over_S", number(standing.worst_error)},
                                   {"wrong", json(standing.wrongness)}});
  }
  return result;
}

template <typename Range>
Json json_list(const Range& items) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(json(item));
  return list;
}

}  // namespace

std::string results_json(const Report& report) {
  Json root;
  root["schema"] = "touchstone.compare_backends/" + std::to_string(kResultsSchema);
  root["command"] = report.options.command_line;
  root["seed"] = report.options.seed;
  root["version"] = report.machine.version;
  root["machine"] = {{"cpu", report.machine.cpu},
                     {"hardware_threads", report.machine.hardware_threads},
                     {"system", report.machine.system},
                     {"compiler", report.machine.compiler},
                     {"build_type", report.machine.build_type},
                     {"flags", report.machine.flags}};
  for (const auto& [name, version] : report.machine.libraries) root["libraries"][name] = version;
  const MeasureOptions measure;
  root["timing"] = {{"pairs_a_family", report.options.pair_count()},
                    {"pairs_a_block", measure.block},
                    {"pairs_a_batch", measure.batch},
                    {"repetitions", report.options.repetitions},
                    {"seconds_a_row_and_repetition_at_most", measure.slow_seconds}};
  for (const auto& [name, text] : kTimingMethod) root["timing"]["definitions"][std::string(name)] = text;
  root["backends"] = Json::array();
  for (const auto& [name, description] : report.backends) {
    root["backends"].push_back({{"name", name}, {"description", description}});
  }
  root["gaps"] = Json::array();
  for (const Gap& gap : report.gaps) root["gaps"].push_back({{"what", gap.what}, {"why", gap.why}});
  root["measured_against_exact"] = report.has_truth;
  for (std::size_t m = 0; m < kMeasures; ++m) {
    root["definitions"][to_string(static_cast<Measure>(m))] = definition(static_cast<Measure>(m));
  }
  root["pair_sets"] = json_list(report.sets);
  root["broadphases"] = json_list(report.broadphases);
  root["scenes"] = json_list(report.scenes);
  root["rankings"] = json_list(report.rankings);
  root["verdicts"] = json_list(report.verdicts);
  return root.dump(1) + "\n";
}

}  // namespace touchstone::comparison
