#include "touchstone/examples/compare_backends/json_parts.hpp"
#include "touchstone/examples/compare_backends/upper_bound.hpp"

namespace touchstone::comparison {

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
                      {"p99", number(shown_p99(result.frame) * 1e-6)},
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
                                  {"frames_told", backend.frames_told},
                                  {"clearance_at_stop_m", number(backend.clearance_at_stop)},
                                  {"worst_clearance_error_m", number(backend.worst_clearance_error)}});
  }
  if (scene.facet_rows.empty()) return result;
  result["facets"] = {{"finest", scene.finest_facets},
                      {"frames", scene.facet_frames},
                      {"frames_near_contact", scene.facet_frames_near},
                      {"frames_that_differ_in_class", scene.facet_class_frames},
                      {"frames_wrong_below_95", number(upper_bound_95(0, scene.facet_frames))},
                      {"budget_m", number(scene.facet_budget)},
                      {"rows", Json::array()}};
  for (const FacetRow& row : scene.facet_rows) {
    result["facets"]["rows"].push_back({{"backend", row.backend},
                                        {"facets", row.facets},
                                        {"query", to_string(row.query)},
                                        {"pairs", row.pairs},
                                        {"frame_ns", number(row.frame_ns)},
                                        {"error_m", number(row.error)},
                                        {"wrong", row.wrong},
                                        {"serves", row.serves}});
  }
  for (const QueryKind query : kQueryKinds) {
    const FacetRow* cheapest = cheapest_row(scene, query);
    Json& least = result["facets"]["least_that_serves"][to_string(query)];
    least = nullptr;
    if (cheapest == nullptr) continue;
    least["backend"] = cheapest->backend;
    least["facets"] = cheapest->facets;
    least["thin"] = thin_evidence(scene, query);
  }
  return result;
}

}  // namespace touchstone::comparison
