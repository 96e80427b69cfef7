#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/results/json_parts.hpp"

namespace touchstone::comparison {
namespace {

using comparison::json;

Json json(const Choice& choice) {
  Json classes = Json::array();
  if (choice.apart) classes.push_back("apart");
  if (choice.touching) classes.push_back("touching");
  if (choice.deep) classes.push_back("deep");
  return {{"query", to_string(choice.query)},
          {"of_sets", choice.sets},
          {"classes", std::move(classes)},
          {"apart_up_to_m", number(upper_end(choice.apart_up_to, kApartBins))},
          {"within_m", number(upper_end(choice.within, kWithinBins))},
          {"normals", choice.normals},
          {"points", choice.points},
          {"max_error_m", number(choice.max_error)},
          {"share", number(choice.share)},
          {"min_coverage", number(choice.min_coverage)},
          {"deadline_s", number(choice.deadline)},
          {"no_allocations", choice.no_allocations}};
}

Json json(const Verdict& verdict, const Candidate& candidate) {
  const Wrongness& wrong = candidate.wrong;
  return {{"backend", candidate.backend},
          {"inside", candidate.inside},
          {"mean_ns", number(candidate.nanoseconds)},
          {"p999_ns", number(candidate.p999_ns)},
          {"allocations", number(candidate.allocations)},
          {"cases", wrong.cases},
          {"beyond", candidate.beyond},
          {"beyond_words", beyond_text(candidate)},
          {"beyond_below_95", number(upper_bound_95(candidate.beyond, wrong.supported()))},
          {"unsupported", wrong.unsupported},
          {"wrong_words", wrong_words(wrong)},
          {"worst_cost_m", number(candidate.worst_cost)},
          {"worst_case", candidate.worst_id},
          {"worst_reason", candidate.worst_reason},
          {"reason_out", reason_out(verdict, candidate)}};
}

}  // namespace

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
  // Posed vertices make the case complete without its set.
  for (int v = 0; v < 8; ++v) {
    result["vertices_A_m"].push_back(json(each.posed.a.vertex(v)));
    result["vertices_B_m"].push_back(json(each.posed.b.vertex(v)));
  }
  // Answers of all backends stand beside the exact one.
  for (const GalleryCase::Answer& answer : each.answers) {
    result["answers"].push_back({{"backend", answer.backend},
                                 {"status", to_string(answer.status)},
                                 {"separation_m", number(answer.separation)},
                                 {"normal", json(answer.n_AB_W)}});
  }
  return result;
}

Json json(const Verdict& verdict) {
  Json result = {{"choice", json(verdict.choice)},
                 {"cases", verdict.cases},
                 {"of_cases", verdict.all},
                 {"fastest", verdict.fastest.empty() ? Json(nullptr) : Json(verdict.fastest)},
                 {"sentence", sentence(verdict)},
                 {"headline", headline(verdict)},
                 {"candidates", Json::array()}};
  for (const Candidate& candidate : verdict.candidates)
    result["candidates"].push_back(json(verdict, candidate));
  return result;
}

Json json(const Ranking& ranking) {
  Json result = {{"query", to_string(ranking.query)}, {"standings", Json::array()}};
  for (const RankedBackend& standing : ranking.standings) {
    result["standings"].push_back({{"backend", standing.backend},
                                   {"mean_ns", number(standing.nanoseconds)},
                                   {"worst_cost_over_S", number(standing.worst_error)},
                                   {"wrong", json(standing.wrong)}});
  }
  return result;
}

}  // namespace touchstone::comparison
