#include "touchstone/examples/measures/truth/oracle.hpp"

#include "touchstone/examples/measures/common/parallel.hpp"

namespace touchstone::measures {

std::vector<PairTruth> compute_truth(const PairSet& set, const Oracle& oracle, int threads,
                                     const Progress& progress) {
  refuse_rounded(set.solids, "comparison with exact answers");
  std::vector<PairTruth> truth(set.cases());
  parallel_chunks(
      set.cases(), 64, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const PosedPair posed = posed_pair(set, i);
          truth[i] = oracle.truth(posed.a, posed.b);
        }
      },
      progress);
  return truth;
}

}  // namespace touchstone::measures
