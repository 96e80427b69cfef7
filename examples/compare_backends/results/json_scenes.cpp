#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/results/json_parts.hpp"

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

namespace {

using comparison::json;

Json json(const TradeRow& row, double allowed) {
  return {{"backend", row.backend},
          {"model", row.model},
          {"hexahedra", row.hexahedra},
          {"selected", row.selected},
          {"pairs", row.pairs},
          {"all_pairs", row.all_pairs},
          {"query", to_string(row.query)},
          {"frame_ns", number(row.frame_ns)},
          {"geometry_error_m", number(row.geometry_error)},
          {"backend_error_m", number(row.backend_error)},
          {"error_m", number(row.error())},
          {"wrong_frames", row.wrong_frames},
          {"serves", row.serves(allowed)}};
}

Json json(const SceneTrade& trade) {
  Json result = {{"allowed_m", number(trade.allowed)},
                 {"frames", trade.frames},
                 {"all_frames", trade.all_frames},
                 {"frames_near_contact", trade.frames_near},
                 {"frames_that_differ_in_class", trade.class_frames},
                 {"frames_wrong_below_95", number(upper_bound_95(0, trade.frames))},
                 {"round", trade.round},
                 {"reference_width_m", number(trade.reference_width)},
                 {"selection_frames", trade.selection_frames},
                 {"rows", Json::array()},
                 {"steps", Json::array()}};
  // Rows stand once, and steps refer to them by index.
  for (const TradeRow& row : trade.rows) result["rows"].push_back(json(row, trade.allowed));
  const auto index = [&](const TradeRow* row) { return row - trade.rows.data(); };
  for (const QueryKind query : kQueryKinds) {
    for (const TradeStep& step : trade_steps(trade, query))
      result["steps"].push_back(
          {{"query", to_string(query)}, {"allowed_m", number(step.allowed)}, {"row", index(step.row)}});
    // The least that serves is null where nothing does.
    const TradeRow* cheapest = cheapest_row(trade, query, trade.allowed);
    Json& least = result["least_that_serves"][to_string(query)];
    least = nullptr;
    if (cheapest == nullptr) continue;
    least["row"] = index(cheapest);
    least["thin"] = thin_evidence(trade, query);
  }
  return result;
}

}  // namespace

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
  // Outcomes count by frame, as a guarded motion would be stopped.
  for (const SceneBackend& backend : scene.backends) {
    result["backends"].push_back({{"backend", backend.name},
                                  {"first_contact_s", optional_number(backend.first_contact)},
                                  {"missed_frames", backend.missed_frames},
                                  {"phantom_frames", backend.phantom_frames},
                                  {"undecided_frames", backend.undecided_frames},
                                  {"frame_outcomes", backend.frame_outcomes},
                                  {"clearance_at_stop_m", number(backend.clearance_at_stop)},
                                  {"worst_clearance_error_m", number(backend.worst_clearance_error)}});
  }
  // The trade is there only where coarser models were measured.
  if (!scene.trade.rows.empty()) result["trade"] = json(scene.trade);
  return result;
}

Json json(const SelectionRow& row) {
  return {
      {"objects", row.objects},
      {"switched_off", row.switched_off},
      {"candidates_per_frame", number(row.candidate_pairs)},
      {"frame_us",
       {{"median", number(row.frame.median_ns * 1e-3)}, {"minimum", number(row.frame.minimum_ns * 1e-3)}}}};
}

}  // namespace touchstone::comparison
