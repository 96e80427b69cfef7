#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// A case worth looking at: the two solids, the exact answer, and what every backend answers to the query.
struct GalleryCase {
  std::string set;  ///< the set's name
  std::string id;
  std::string replay;   ///< the command that shows it in full
  std::string backend;  ///< whose worst case it is
  QueryKind query = QueryKind::distance;
  std::string reason;
  double cost = 0;  ///< the error of that backend's answer to that query [m]
  PosedPair posed;
  PairTruth truth;
  struct Answer {
    std::string backend;
    PairStatus status = PairStatus::unsupported;
    double separation = 0;  ///< NaN: none, as of an overlap
    Vector3 n_AB_W = Vector3::Zero();
  };
  std::vector<Answer> answers;
};
inline constexpr std::size_t kGallerySize = 12;

/// Adds each backend's worst answer of the set: of all queries, the largest error over S of a figure that it
/// carries (distance, depth, normal, points; whatever its class) or, of a contact missed or a phantom, of
/// what separates the class from the right one. `undecided`, `failed` and `unsupported` alone claim nothing.
void collect_cases(const PairSet& set, std::span<const PairTruth> truth,
                   std::span<const BackendAnswers> answers, const SetResult& result,
                   std::vector<GalleryCase>& gallery);

/// The most cases of one backend.
inline constexpr int kGalleryOfOne = 3;
/// The kGallerySize of the largest cost over S, each case once and at most kGalleryOfOne of one backend.
std::vector<GalleryCase> worst_of(std::vector<GalleryCase> gallery);

}  // namespace touchstone::comparison
