#include "touchstone/examples/compare_backends/judge/verdict_texts.hpp"
#include "touchstone/examples/compare_backends/results/json_parts.hpp"

namespace touchstone::comparison {
namespace {

using comparison::json;

Json json(const ChoiceSet& set) {
  Json result = {{"name", set.name}, {"cases", set.cases}, {"ids", set.ids}, {"backends", Json::array()}};
  for (const ChoiceSet::Backend& backend : set.backends) {
    Json entry = {{"backend", backend.name}};
    for (const QueryKind kind : kQueryKinds) {
      const ChoiceSet::Answers& answers = backend.queries[index_of(kind)];
      entry["queries"][to_string(kind)] = {{"ns", number(answers.nanoseconds)},
                                           {"p999_ns", number(answers.p999_ns)},
                                           {"allocations", number(answers.allocations)},
                                           {"curves", text_of(answers.curves, kind)}};
    }
    result["backends"].push_back(std::move(entry));
  }
  return result;
}

}  // namespace

Json json(const std::vector<ChoiceSet>& sets) {
  Json result = {
      {"deep_over_size", kDeepOverSize},  {"apart_bins_m", kApartBins},      {"within_bins_m", kWithinBins},
      {"coverage_bins", kCoverageBins},   {"codes_a_decade", kCodesADecade}, {"last_code", kLastCode},
      {"first_exponent", kFirstExponent}, {"reasons", kCostReasons},         {"sets", Json::array()}};
  for (const VerdictText& each : kVerdictTexts) result["texts"][std::string(each.name)] = each.text;
  for (const ChoiceSet& set : sets) result["sets"].push_back(json(set));
  return result;
}

}  // namespace touchstone::comparison
