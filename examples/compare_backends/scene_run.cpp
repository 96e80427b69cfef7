#include "touchstone/examples/compare_backends/scene_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "touchstone/examples/compare_backends/comparison.hpp"
#include "touchstone/examples/measures/parallel.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What a whole frame says: the union of its pairs' answers.
struct FrameAnswer {
  bool contact = false;      // some pair overlaps
  bool unsure = false;       // some pair is undecided, failed or unsupported
  double least = kInfinity;  // least separation [m]; NaN when some pair's is missing
};

FrameAnswer frame_answer(const QueryAnswers& answers, std::size_t frame, std::size_t pairs) {
  FrameAnswer result;
  for (std::size_t i = frame * pairs; i < (frame + 1) * pairs; ++i) {
    result.contact |= answers.status[i] == PairStatus::overlapping;
    const bool decided =
        answers.status[i] == PairStatus::overlapping || answers.status[i] == PairStatus::separated;
    result.unsure |= !decided;
    if (answers.geometry.empty()) continue;
    const double separation = answers.geometry[i].separation;
    if (std::isnan(separation) || std::isnan(result.least)) {
      result.least = std::numeric_limits<double>::quiet_NaN();
    } else {
      result.least = std::min(result.least, separation);
    }
  }
  return result;
}

double exact_least(std::span<const PairTruth> truth, std::size_t frame, std::size_t pairs) {
  double least = kInfinity;
  for (std::size_t i = frame * pairs; i < (frame + 1) * pairs; ++i)
    least = std::min(least, truth[i].separation);
  return least;
}

SceneBackend follow(const BackendAnswers& answers, const SceneFrames& frames, std::span<const double> exact) {
  SceneBackend result;
  result.name = answers.name;
  result.clearance_at_stop = std::numeric_limits<double>::quiet_NaN();
  const std::size_t pairs = frames.set.pairs.size();
  for (std::size_t f = 0; f < frames.times.size(); ++f) {
    const FrameAnswer overlap = frame_answer(answers.queries[index_of(QueryKind::overlap)], f, pairs);
    if (overlap.contact && !result.first_contact) result.first_contact = frames.times[f];
    if (exact.empty()) continue;
    const bool contact = exact[f] <= 0.0;
    if (overlap.contact && !contact)
      ++result.phantom_frames;
    else if (!overlap.contact && overlap.unsure)
      ++result.undecided_frames;
    else if (!overlap.contact && contact)
      ++result.missed_frames;
    const bool blocks = overlap.contact || overlap.unsure;
    if (blocks && f > 0 && result.frames_told.find_first_of("bw") == std::string::npos)
      result.clearance_at_stop = exact[f - 1];
    result.frames_told += blocks ? (contact ? 'b' : 'w') : contact ? 'm' : '.';
    const FrameAnswer distance = frame_answer(answers.queries[index_of(QueryKind::distance)], f, pairs);
    const double error = std::abs(distance.least - exact[f]);
    if (std::isfinite(error))
      result.worst_clearance_error = std::max(result.worst_clearance_error, error);
    else
      result.worst_clearance_error = std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

// The error of one query over the frames, against the exact clearance `exact` of the finest facets.
double facet_error(const BackendAnswers& answers, QueryKind query, std::size_t pairs,
                   std::span<const double> exact) {
  double worst = 0.0;
  for (std::size_t f = 0; f < exact.size(); ++f) {
    const FrameAnswer answer = frame_answer(answers.queries[index_of(query)], f, pairs);
    const bool contact = exact[f] <= 0.0;
    double error = 0.0;
    if ((!answer.contact && answer.unsure) || answer.contact != contact) {
      error = std::abs(exact[f]);
      if (query == QueryKind::distance) error = std::max(error, std::abs(answer.least - exact[f]));
    } else if (query == QueryKind::distance || (query == QueryKind::manifold && contact)) {
      error = std::abs(answer.least - exact[f]);
    }
    if (std::isnan(error)) error = kInfinity;
    worst = std::max(worst, error);
  }
  return worst;
}

// Exact clearance of each frame. Pairs whose bounding spheres are further apart than another pair's exact
// separation are not computed.
std::vector<double> exact_clearance(const PairSet& set, const Oracle& oracle, int threads) {
  std::vector<double> least(set.frames(), kInfinity);
  parallel_chunks(set.frames(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const auto poses = set.frame_poses(f);
      std::vector<std::pair<double, std::size_t>> order;
      for (std::size_t p = 0; p < set.pairs.size(); ++p) {
        const auto [a, b] = set.pairs[p];
        const Sphere &sa = set.solids[a].bounding_sphere(), &sb = set.solids[b].bounding_sphere();
        const double apart = norm(transform(poses[b], sb.centre) - transform(poses[a], sa.centre));
        order.emplace_back(apart - (sa.radius + sb.radius) * (1 + 1e-9), p);  // generous to rounding
      }
      std::sort(order.begin(), order.end());
      for (const auto& [bound, p] : order) {
        if (bound > least[f]) break;
        const PosedPair posed = posed_pair(set, f * set.pairs.size() + p);
        least[f] = std::min(least[f], oracle.truth(posed.a, posed.b).separation);
      }
    }
  });
  return least;
}

// What run_scene found at the scene's own facets, where the facet frames are looked for.
struct Motion {
  std::span<const std::size_t> numbers;  // of the frames
  std::span<const double> exact;         // clearance in each
};

using FramesAt = std::function<SceneFrames(int facets, std::span<const std::size_t> numbers)>;

// The frame of the first contact at the finest facets, or of the least clearance. Only some frames may have
// been stepped: those between the two around it are looked at too.
std::size_t first_contact_frame(const Motion& motion, const FramesAt& frames_at, int finest,
                                const Oracle& oracle, int threads) {
  const auto first =
      std::find_if(motion.exact.begin(), motion.exact.end(), [](double d) { return d <= 0.0; });
  const auto found =
      first != motion.exact.end() ? first : std::min_element(motion.exact.begin(), motion.exact.end());
  const auto at = static_cast<std::size_t>(found - motion.exact.begin());
  std::vector<std::size_t> between;
  for (std::size_t f = motion.numbers[at > 0 ? at - 1 : 0];
       f <= motion.numbers[std::min(at + 1, motion.numbers.size() - 1)]; ++f)
    between.push_back(f);
  const std::vector<double> exact = exact_clearance(frames_at(finest, between).set, oracle, threads);
  const auto contact = std::find_if(exact.begin(), exact.end(), [](double d) { return d <= 0.0; });
  const auto here = contact != exact.end() ? contact : std::min_element(exact.begin(), exact.end());
  return between[static_cast<std::size_t>(here - exact.begin())];
}

// Half of the frames one after the other around `centre`, the others evenly spread.
std::vector<std::size_t> facet_frames(std::size_t all, std::size_t count, std::size_t centre,
                                      SceneResult& result) {
  count = std::min(count, all);
  const std::size_t near = (count + 1) / 2;
  const std::size_t begin = std::min(centre - std::min(centre, near / 2), all - near);
  std::set<std::size_t> numbers;
  for (std::size_t f = begin; f < begin + near; ++f) numbers.insert(f);
  for (const std::size_t f : spread_frames(all, count - near)) numbers.insert(f);
  result.facet_frames = numbers.size();
  result.facet_frames_near = near;
  return {numbers.begin(), numbers.end()};
}

bool is_wrong(const SetResult& set, const std::string& backend, QueryKind query) {
  return std::any_of(set.backends.begin(), set.backends.end(), [&](const BackendResult& each) {
    return each.name == backend && each.is_wrong(index_of(query));
  });
}

void run_facets(SceneResult& result, const SceneOptions& options, const Motion& motion, const Oracle& oracle,
                const AnswerSet& answer, const Progress& progress) {
  result.finest_facets = options.facets.back();
  result.facet_budget = options.max_error.value_or(result.gap);
  MeasureOptions measure = options.measure;
  measure.time_pairs = false;
  measure.time_frames = true;
  measure.perturb = false;
  const FramesAt frames_at = [&](int facets, std::span<const std::size_t> numbers) {
    std::map<std::string, double> parameters = options.parameters;
    parameters["facets"] = facets;
    return load_scene_frames(result.file, parameters, numbers);
  };
  const std::size_t centre =
      first_contact_frame(motion, frames_at, result.finest_facets, oracle, measure.threads);
  const std::vector<std::size_t> numbers =
      facet_frames(result.all_frames, options.facet_frames, centre, result);
  const std::vector<double> exact =
      exact_clearance(frames_at(result.finest_facets, numbers).set, oracle, measure.threads);
  const std::vector<double> coarsest =
      exact_clearance(frames_at(options.facets.front(), numbers).set, oracle, measure.threads);
  for (std::size_t f = 0; f < exact.size(); ++f)
    result.facet_class_frames += (exact[f] <= 0.0) != (coarsest[f] <= 0.0);
  for (std::size_t i = 0; i < options.facets.size(); ++i) {
    const SceneFrames frames = frames_at(options.facets[i], numbers);
    for (const BackendAnswers& answers : answer(frames.set, measure)) {
      for (const QueryKind query : kQueryKinds) {
        const auto& timing = answers.frame_by_query[index_of(query)];
        if (!timing) continue;
        const double error = facet_error(answers, query, frames.set.pairs.size(), exact);
        const bool wrong = is_wrong(result.set, answers.name, query);
        result.facet_rows.push_back({answers.name, options.facets[i], query, frames.set.pairs.size(),
                                     timing->median_ns, error, wrong,
                                     error <= result.facet_budget && !wrong});
      }
    }
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(options.facets.size()));
  }
}

}  // namespace

const FacetRow* cheapest_row(const SceneResult& scene, QueryKind query) {
  const FacetRow* cheapest = nullptr;
  for (const FacetRow& row : scene.facet_rows) {
    if (row.query != query || !row.serves) continue;
    if (cheapest == nullptr || row.frame_ns < cheapest->frame_ns) cheapest = &row;
  }
  return cheapest;
}

std::string thin_evidence(const SceneResult& scene, QueryKind query) {
  if (scene.facet_frames < kLeastFacetFrames)
    return "too few frames (" + std::to_string(scene.facet_frames) + ", at least " +
           std::to_string(kLeastFacetFrames) + " leave less than 5 % unknown)";
  if (query == QueryKind::overlap && scene.facet_class_frames == 0)
    return "no frame lies where the facet counts differ in class";
  return "";
}

SceneResult run_scene(const std::string& file, const SceneOptions& options, const Oracle* oracle,
                      const AnswerSet& answer, const Progress& progress) {
  const SceneFrames frames = load_scene_frames(file, options.parameters, options.most_frames);
  SceneResult result;
  result.name = frames.set.name;
  result.description = frames.description;
  result.file = file;
  result.rate = frames.rate;
  result.duration = frames.duration;
  result.gap = frames.gap;
  result.parameters = frames.parameters;
  result.frames = frames.times.size();
  result.all_frames = frames.all_frames;
  result.pairs = frames.set.pairs.size();

  MeasureOptions measure = options.measure;
  measure.time_pairs = false;
  measure.time_frames = true;
  measure.perturb = false;
  std::vector<PairTruth> truth;
  std::vector<double> exact;
  if (oracle != nullptr) {
    truth = compute_truth(frames.set, *oracle, measure.threads, progress);
    for (std::size_t f = 0; f < result.frames; ++f) exact.push_back(exact_least(truth, f, result.pairs));
    const auto first = std::find_if(exact.begin(), exact.end(), [](double d) { return d <= 0.0; });
    if (first != exact.end())
      result.exact_first_contact = frames.times[static_cast<std::size_t>(first - exact.begin())];
  }
  const std::vector<BackendAnswers> answers = answer(frames.set, measure);
  for (const BackendAnswers& backend : answers) result.backends.push_back(follow(backend, frames, exact));
  result.set = sum_up(frames.set, truth, oracle, answers, measure.threads, progress);
  result.set.ids = frames.set.ids;
  if (oracle != nullptr) collect_cases(frames.set, truth, answers, result.set, result.worst_cases);
  if (frames.has_facets && oracle != nullptr)
    run_facets(result, options, {frames.numbers, exact}, *oracle, answer, progress);
  return result;
}

}  // namespace touchstone::comparison
