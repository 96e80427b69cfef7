#include "examples/compare_backends/gallery.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace touchstone::comparison {
namespace {

GalleryCase::Answer answer_of(const BackendAnswers& answers, std::size_t index) {
  const QueryAnswers& distance = answers.queries[index_of(QueryKind::distance)];
  GalleryCase::Answer answer;
  answer.backend = answers.name;
  answer.status = distance.status[index];
  const bool carries = answer.status != PairStatus::failed && answer.status != PairStatus::unsupported;
  answer.separation =
      carries ? distance.geometry[index].separation : std::numeric_limits<double>::quiet_NaN();
  if (carries) answer.n_AB_W = distance.geometry[index].n_AB_W;
  return answer;
}

}  // namespace

void collect_cases(const PairSet& set, std::span<const PairTruth> truth,
                   std::span<const BackendAnswers> answers, const SetResult& result,
                   std::vector<GalleryCase>& gallery) {
  for (const BackendResult& backend : result.backends) {
    const Quantiles& cost = backend.judgement.cost[index_of(QueryKind::distance)];
    const WorstCase& dearest = backend.judgement.worst[index_of(QueryKind::distance)];
    if (cost.count == 0 || !(cost.worst > 0) || !std::isfinite(cost.worst)) continue;
    if (std::string_view(dearest.reason) == "unsupported") continue;
    GalleryCase shown;
    shown.id = case_id(set, dearest.index);
    shown.backend = backend.name;
    shown.reason = dearest.reason;
    shown.cost = dearest.cost;
    shown.posed = posed_pair(set, dearest.index);
    shown.truth = truth[dearest.index];
    for (const BackendAnswers& each : answers) shown.answers.push_back(answer_of(each, dearest.index));
    gallery.push_back(std::move(shown));
  }
}

std::vector<GalleryCase> worst_of(std::vector<GalleryCase> gallery) {
  std::stable_sort(gallery.begin(), gallery.end(), [](const GalleryCase& x, const GalleryCase& y) {
    return x.cost / x.posed.scale > y.cost / y.posed.scale;
  });
  std::vector<GalleryCase> kept;
  std::set<std::string> ids;
  std::map<std::string, int> of_backend;
  for (GalleryCase& each : gallery) {
    if (kept.size() == kGallerySize) break;
    if (of_backend[each.backend] == 3 || !ids.insert(each.id).second) continue;
    ++of_backend[each.backend];
    kept.push_back(std::move(each));
  }
  return kept;
}

}  // namespace touchstone::comparison
