#include "touchstone/examples/compare_backends/json_parts.hpp"

namespace touchstone::comparison {
namespace {

Json json(const Candidate& candidate) {
  return {{"backend", candidate.backend},
          {"mean_ns", number(candidate.nanoseconds)},
          {"worst_cost_m", number(candidate.worst_cost)},
          {"worst_case", candidate.worst_id},
          {"worst_reason", candidate.worst_reason},
          {"wrong", candidate.wrong.total()},
          {"wrong_words", wrong_words(candidate.wrong)},
          {"cases", candidate.wrong.cases},
          {"missed", candidate.wrong.missed},
          {"phantom", candidate.wrong.phantom},
          {"undecided", candidate.wrong.undecided},
          {"failed", candidate.wrong.failed},
          {"unsupported", candidate.wrong.unsupported},
          {"missing_value", candidate.wrong.missing}};
}

}  // namespace

Json json(const Candidates& candidates) {
  Json result = {{"query", to_string(candidates.query)}, {"candidates", Json::array()}};
  for (const Candidate& each : candidates.candidates) result["candidates"].push_back(json(each));
  return result;
}

Json json(const DriftRun& run) {
  Json result = {{"scene", run.scene}, {"backend", run.backend}};
  if (!run.gap.empty()) {
    result["gap"] = run.gap;
    return result;
  }
  result["pose_error_m"] = number(run.pose_error);
  result["unexplained_momentum_ns"] = number(run.momentum);
  result["energy_made_over_scale"] = number(run.energy_made);
  result["deepest_m"] = number(run.deepest);
  result["step_ns"] = number(run.step_ns);
  result["step_p99_9_ns"] = number(run.p999_ns);
  result["allocations"] = number(run.allocations);
  result["misses"] = run.misses;
  result["answers"] = run.answers;
  result["answers_met"] = run.met;
  result["build_on"] = run.build_on;
  return result;
}

Json json(const ThreadResult& run) {
  Json result = {{"backend", run.backend},
                 {"query", to_string(run.query)},
                 {"threads", run.threads},
                 {"pairs", run.pairs},
                 {"wrong", run.wrong}};
  if (run.gap.empty())
    result["pass"] = json(std::optional(run.pass));
  else
    result["gap"] = run.gap;
  return result;
}

Json json(const GalleryCase& each) {
  Json result = {{"case", each.id},
                 {"replay", each.replay},
                 {"set", each.set},
                 {"query", to_string(each.query)},
                 {"shown_for", each.backend},
                 {"reason", each.reason},
                 {"cost_m", number(each.cost)},
                 {"cost_over_S", number(each.cost / each.posed.scale)},
                 {"S_m", number(each.posed.scale)},
                 {"exact",
                  {{"class", to_string(each.truth.pair_class)},
                   {"separation_m", number(each.truth.separation)},
                   {"normal", json(each.truth.n_AB_W)},
                   {"normal_unique", each.truth.normal_unique}}},
                 {"answers", Json::array()}};
  for (int v = 0; v < 8; ++v) {
    result["vertices_A_m"].push_back(json(each.posed.a.vertex(v)));
    result["vertices_B_m"].push_back(json(each.posed.b.vertex(v)));
  }
  for (const GalleryCase::Answer& answer : each.answers) {
    result["answers"].push_back({{"backend", answer.backend},
                                 {"status", to_string(answer.status)},
                                 {"separation_m", number(answer.separation)},
                                 {"normal", json(answer.n_AB_W)}});
  }
  return result;
}

Json json(const Verdict& verdict) {
  Json result = {{"query", to_string(verdict.query)},
                 {"max_error_m", number(verdict.max_error)},
                 {"fastest", verdict.fastest.empty() ? Json(nullptr) : Json(verdict.fastest)},
                 {"sentence", sentence(verdict)},
                 {"headline", headline(verdict)},
                 {"candidates", Json::array()}};
  for (const Candidate& candidate : verdict.candidates) {
    result["candidates"].push_back({{"backend", candidate.backend},
                                    {"inside", candidate.inside},
                                    {"mean_ns", number(candidate.nanoseconds)},
                                    {"worst_cost_m", number(candidate.worst_cost)},
                                    {"worst_case", candidate.worst_id},
                                    {"worst_reason", candidate.worst_reason},
                                    {"reason_out", reason_out(verdict, candidate)}});
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

}  // namespace touchstone::comparison
