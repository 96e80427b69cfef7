#include "touchstone/examples/compare_backends/judge/gallery.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::comparison {
namespace {

GalleryCase::Answer answer_of(const BackendAnswers& answers, QueryKind query, std::size_t index) {
  const QueryAnswers& given = answers.queries[index_of(query)];
  GalleryCase::Answer answer;
  answer.backend = answers.name;
  answer.status = given.status[index];
  const bool carries = !given.geometry.empty() && answer.status != PairStatus::failed &&
                       answer.status != PairStatus::unsupported;
  answer.separation = carries ? given.geometry[index].separation : kNaN;
  if (carries) answer.n_AB_W = given.geometry[index].n_AB_W;
  return answer;
}

// One backend's worst answer so far.
struct Worst {
  double over_scale = 0;
  std::size_t index = 0;
  QueryKind query = QueryKind::distance;
  const char* reason = "";

  void note(double value, std::size_t at, QueryKind of, const char* why) {
    if (std::isfinite(value) && value > over_scale) *this = {value, at, of, why};
  }
};

struct Carried {
  Measure measure;
  QueryKind query;
  const char* reason;
};
constexpr Carried kCarried[] = {{Measure::distance, QueryKind::distance, "distance"},
                                {Measure::depth, QueryKind::distance, "depth"},
                                {Measure::normal, QueryKind::distance, "normal"},
                                {Measure::witness, QueryKind::distance, "closest points"},
                                {Measure::deepest, QueryKind::manifold, "deepest point"},
                                {Measure::point_witness, QueryKind::manifold, "contact points"}};

Worst worst_answer(const BackendAnswers& answers, const Judgement& judgement,
                   std::span<const PairTruth> truth, std::span<const double> scale) {
  Worst worst;
  for (const QueryKind query : kQueryKinds) {
    const std::vector<PairStatus>& status = answers.queries[index_of(query)].status;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const bool contact = status[i] == PairStatus::overlapping;
      if (!contact && status[i] != PairStatus::separated) continue;
      if (contact != truth[i].contact())
        worst.note(std::abs(truth[i].separation) / scale[i], i, query,
                   contact ? "phantom contact" : "missed contact");
    }
  }
  for (const Carried& carried : kCarried) {
    const Quantiles& errors = judgement.errors[static_cast<std::size_t>(carried.measure)].over_scale;
    if (errors.count > 0) worst.note(errors.worst, errors.worst_case, carried.query, carried.reason);
  }
  return worst;
}

}  // namespace

void collect_cases(const PairSet& set, std::span<const PairTruth> truth,
                   std::span<const BackendAnswers> answers, const SetResult& result,
                   std::vector<GalleryCase>& gallery) {
  std::vector<double> scale;
  for (std::size_t i = 0; i < truth.size(); ++i) scale.push_back(posed_pair(set, i).scale);
  for (std::size_t b = 0; b < answers.size(); ++b) {
    const Worst worst = worst_answer(answers[b], result.backends[b].judgement, truth, scale);
    if (worst.over_scale == 0) continue;
    GalleryCase shown;
    shown.set = set.name;
    shown.id = case_id(set, worst.index);
    shown.backend = answers[b].name;
    shown.query = worst.query;
    shown.reason = worst.reason;
    shown.cost = worst.over_scale * scale[worst.index];
    shown.posed = posed_pair(set, worst.index);
    shown.truth = truth[worst.index];
    for (const BackendAnswers& each : answers)
      shown.answers.push_back(answer_of(each, worst.query, worst.index));
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
    if (of_backend[each.backend] == kGalleryOfOne || !ids.insert(each.id).second) continue;
    ++of_backend[each.backend];
    kept.push_back(std::move(each));
  }
  return kept;
}

}  // namespace touchstone::comparison
