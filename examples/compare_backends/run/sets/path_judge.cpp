#include "touchstone/examples/compare_backends/run/sets/path_judge.hpp"

#include <algorithm>

namespace touchstone::comparison {

PathJudge::PathJudge(const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                     std::span<const PairTruth> poses_truth, const Oracle& oracle, int threads)
    : pairs_(pairs),
      poses_(set.poses),
      poses_truth_(poses_truth),
      oracle_(oracle),
      truth_(compute_path_truth(pairs, set.poses, oracle, threads)) {
  check_impacts(corpus, set, pairs, truth_);
}

PathSetResult PathJudge::begin() const { return begin_paths(pairs_, poses_, truth_, poses_truth_); }

PathBackendResult PathJudge::result_of(const BackendAnswers& answers,
                                       std::span<const BackendRegistry::NarrowphaseEntry* const> here) const {
  const auto entry =
      std::find_if(here.begin(), here.end(), [&](const auto* each) { return each->name == answers.name; });
  PathAnswers impacts;
  impacts.backend = answers.name;
  if (entry == here.end())
    impacts.why_none = "runs in a process of its own, which is asked about poses alone";
  else
    impacts = run_paths(**entry, pairs_, poses_);
  return judge_paths(pairs_, poses_, truth_, poses_truth_, impacts,
                     answers.queries[index_of(QueryKind::overlap)].status, oracle_);
}

PathBackendResult PathJudge::result_of(const SweepEntry& sweep) const {
  return judge_paths(pairs_, poses_, truth_, poses_truth_, run_sweep(sweep, pairs_, poses_), {}, oracle_);
}

}  // namespace touchstone::comparison
