#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"

namespace touchstone::comparison {
namespace {

BackendResult sum_up_backend(const BackendAnswers& answers) {
  BackendResult result;
  result.name = answers.name;
  result.description = answers.description;
  result.capabilities = answers.capabilities;
  result.frame = answers.frame_by_query;
  result.failure = answers.failure;
  result.consistency = answers.consistency;
  for (const QueryKind kind : kQueryKinds) {
    const QueryAnswers& query = answers.queries[index_of(kind)];
    result.rows[index_of(kind)] = {query.single, query.batch, query.raw, query.cached, query.allocations};
  }
  return result;
}

SetResult without_backends(const PairSet& set, std::span<const PairTruth> truth) {
  SetResult result;
  result.name = set.name;
  result.description = set.description;
  result.cases = set.cases();
  result.pairs = set.pairs.size();
  result.ids = set.ids;
  for (const PairTruth& each : truth) {
    result.contacts += each.contact();
    result.touching += each.pair_class == PairClass::touching;
  }
  return result;
}

}  // namespace

SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth, const Oracle* oracle,
                 std::span<const BackendAnswers> answers, int threads, const Progress& progress) {
  SetResult result = without_backends(set, truth);
  for (std::size_t b = 0; b < answers.size(); ++b) {
    result.backends.push_back(sum_up_backend(answers[b]));
    if (oracle == nullptr) continue;
    const auto part = [&](double done) {
      if (progress) progress((static_cast<double>(b) + done) / static_cast<double>(answers.size()));
    };
    result.backends.back().judgement = judge(set, truth, *oracle, answers[b], threads, part);
    result.backends.back().judged = true;
  }
  return result;
}

SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth,
                 std::span<const BackendAnswers> answers, std::span<const std::vector<CaseErrors>> errors) {
  SetResult result = without_backends(set, truth);
  for (std::size_t b = 0; b < answers.size(); ++b) {
    BackendResult& backend = result.backends.emplace_back(sum_up_backend(answers[b]));
    backend.judged = !errors.empty();
    if (backend.judged) backend.judgement = judge(set, truth, answers[b], errors[b]);
  }
  return result;
}

}  // namespace touchstone::comparison
