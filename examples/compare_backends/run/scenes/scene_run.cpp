#include "touchstone/examples/compare_backends/run/scenes/scene_run.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/run/scenes/frame_answer.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"

namespace touchstone::comparison {
namespace {

double exact_least(std::span<const PairTruth> truth, std::size_t frame, std::size_t pairs) {
  double least = kInfinity;
  for (std::size_t i = frame * pairs; i < (frame + 1) * pairs; ++i)
    least = std::min(least, truth[i].separation);
  return least;
}

SceneBackend follow(const BackendAnswers& answers, const SceneFrames& frames, std::span<const double> exact) {
  SceneBackend result;
  result.name = answers.name;
  result.clearance_at_stop = kNaN;
  const std::size_t pairs = frames.set.pairs.size();
  for (std::size_t f = 0; f < frames.times.size(); ++f) {
    // The first contact is known without exact answers; errors are not.
    const FrameAnswer overlap = frame_answer(answers.queries[index_of(QueryKind::overlap)], f, pairs);
    if (overlap.contact && !result.first_contact) result.first_contact = frames.times[f];
    if (exact.empty()) continue;
    // A frame is missed, phantom, undecided or right.
    const bool contact = exact[f] <= 0.0;
    if (overlap.contact && !contact)
      ++result.phantom_frames;
    else if (!overlap.contact && overlap.unsure)
      ++result.undecided_frames;
    else if (!overlap.contact && contact)
      ++result.missed_frames;
    // The clearance at the stop is that of the last frame before the first that blocks.
    const bool blocks = overlap.contact || overlap.unsure;
    if (blocks && f > 0 && result.frame_outcomes.find_first_of("bw") == std::string::npos)
      result.clearance_at_stop = exact[f - 1];
    result.frame_outcomes += blocks ? (contact ? 'b' : 'w') : contact ? 'm' : '.';
    // A distance that is missing leaves the worst error unknown.
    const FrameAnswer distance = frame_answer(answers.queries[index_of(QueryKind::distance)], f, pairs);
    const double error = std::abs(distance.least - exact[f]);
    if (std::isfinite(error))
      result.worst_clearance_error = std::max(result.worst_clearance_error, error);
    else
      result.worst_clearance_error = kNaN;
  }
  return result;
}

}  // namespace

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

  // Frames are timed, not pairs.
  MeasureOptions measure = options.measure;
  measure.time_pairs = false;
  measure.time_frames = true;
  measure.perturb = false;
  // The exact first contact.
  std::vector<PairTruth> truth;
  std::vector<double> exact;
  if (oracle != nullptr) {
    truth = compute_truth(frames.set, *oracle, measure.threads, progress);
    for (std::size_t f = 0; f < result.frames; ++f) exact.push_back(exact_least(truth, f, result.pairs));
    const auto first = std::find_if(exact.begin(), exact.end(), [](double d) { return d <= 0.0; });
    if (first != exact.end())
      result.exact_first_contact = frames.times[static_cast<std::size_t>(first - exact.begin())];
  }
  // The backends, and what coarser facets would trade.
  const std::vector<BackendAnswers> answers = answer(frames.set, measure);
  for (const BackendAnswers& backend : answers) result.backends.push_back(follow(backend, frames, exact));
  result.set = sum_up(frames.set, truth, oracle, answers, measure.threads, progress);
  result.set.ids = frames.set.ids;
  if (oracle != nullptr) collect_cases(frames.set, truth, answers, result.set, result.worst_cases);
  if (oracle != nullptr && result.pairs > 0) {
    const TradeOptions trade = {options.parameters, options.measure, options.max_error, options.facets,
                                options.trade_frames};
    result.trade = run_trade(file, frames, exact, trade, *oracle, answer, progress);
  }
  return result;
}

}  // namespace touchstone::comparison
