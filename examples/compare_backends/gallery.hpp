#pragma once

#include <string>
#include <vector>

#include "examples/compare_backends/set_result.hpp"

namespace touchstone::comparison {

/// A case worth looking at: the two solids, the exact answer, and what every backend says of their distance.
struct GalleryCase {
  std::string id;
  std::string replay;   ///< the command that shows it in full
  std::string backend;  ///< whose worst case it is
  std::string reason;
  double cost = 0;  ///< of that backend's answer [m]
  PosedPair posed;
  PairTruth truth;
  struct Answer {
    std::string backend;
    PairStatus status = PairStatus::unsupported;
    double separation = 0;  ///< NaN: none
    Vector3 n_AB_W = Vector3::Zero();
  };
  std::vector<Answer> answers;
};
inline constexpr std::size_t kGallerySize = 12;

/// Adds each backend's worst case of the set in the distance query: a wrong class, a wrong figure, not what
/// it does not support.
void collect_cases(const PairSet& set, std::span<const PairTruth> truth,
                   std::span<const BackendAnswers> answers, const SetResult& result,
                   std::vector<GalleryCase>& gallery);

/// The kGallerySize of the largest cost over S, each case once and at most three of one backend.
std::vector<GalleryCase> worst_of(std::vector<GalleryCase> gallery);

}  // namespace touchstone::comparison
