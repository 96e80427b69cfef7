#pragma once

#include "touchstone/examples/compare_backends/judge/path_result.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"

namespace touchstone::comparison {

/// Asks backends for the times of impact of a corpus's set of paths, and judges them.
class PathJudge {
 public:
  /// @param poses_truth of the set's cases. All are kept by reference.
  /// @throws InputError where `exact` finds another time of impact than the corpus has.
  PathJudge(const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
            std::span<const PairTruth> poses_truth, const Oracle& oracle, int threads);

  PathSetResult begin() const;
  /// @param answers about the set's pairs. @param here the backends of this process: others are not asked.
  PathBackendResult result_of(const BackendAnswers& answers,
                              std::span<const BackendRegistry::NarrowphaseEntry* const> here) const;
  PathBackendResult result_of(const SweepEntry& sweep) const;

 private:
  const PairSet& pairs_;
  std::size_t poses_;
  std::span<const PairTruth> poses_truth_;
  const Oracle& oracle_;
  std::vector<PathTruth> truth_;
};

}  // namespace touchstone::comparison
