#include <algorithm>
#include <cmath>
#include <set>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/scenes/frame_answer.hpp"
#include "touchstone/examples/compare_backends/run/scenes/pair_choice.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_trade.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"

namespace touchstone::comparison {
namespace {

// A way to model the scene.
struct Model {
  std::string name;
  std::optional<int> facets;  // empty: the scene's own
  std::optional<int> cover_level;
};

// Half of the frames one after the other around `centre`, the others evenly spread.
std::vector<std::size_t> judged_frames(std::size_t all, std::size_t count, std::size_t centre,
                                       SceneTrade& trade) {
  if (all <= kLeastTradeFrames) count = all;
  count = std::min(count, all);
  const std::size_t near = (count + 1) / 2;
  const std::size_t begin = std::min(centre - std::min(centre, near / 2), all - near);
  std::set<std::size_t> numbers;
  for (std::size_t f = begin; f < begin + near; ++f) numbers.insert(f);
  for (const std::size_t f : spread_frames(all, count - near)) numbers.insert(f);
  if (count == all)
    for (std::size_t f = 0; f < all; ++f) numbers.insert(f);
  trade.frames = numbers.size();
  trade.all_frames = numbers.size() == all;
  trade.frames_near = near;
  return {numbers.begin(), numbers.end()};
}

std::size_t wrong_frames(const QueryAnswers& answers, std::size_t pairs, std::span<const double> exact) {
  std::size_t wrong = 0;
  for (std::size_t f = 0; f < exact.size(); ++f) {
    const FrameAnswer answer = frame_answer(answers, f, pairs);
    wrong += (!answer.contact && answer.unsure) || answer.contact != (exact[f] <= 0.0);
  }
  return wrong;
}

// The median frame of the repetition that was disturbed least: rows of one table are timed one after the
// other.
double quiet_median(const Timing& timing) {
  double least = timing.median_ns;
  for (std::size_t r = 0; r < timing.repetitions; ++r) least = std::min(least, timing.repetition_ns[r]);
  return least;
}

class TradeRun {
 public:
  TradeRun(const std::string& file, const SceneFrames& stepped, const TradeOptions& options,
           const Oracle& oracle, const AnswerSet& answer)
      : file_(file), stepped_(stepped), options_(options), oracle_(oracle), answer_(answer) {
    measure_ = options.measure;
    measure_.time_pairs = false;
    measure_.time_frames = true;
    measure_.perturb = false;
    trade_.allowed = options.max_error.value_or(stepped.gap);
    trade_.round = !stepped.tubes.empty();
    trade_.selection_frames = stepped.numbers.size();
  }

  SceneTrade run(std::span<const double> exact, const Progress& progress) {
    numbers_ = judged_frames(stepped_.all_frames, options_.frames, first_contact_frame(exact), trade_);
    make_reference();
    const std::vector<Model> models = this->models();
    trade_.models = models.size();
    for (std::size_t i = 0; i < models.size(); ++i) {
      add_model(models[i]);
      if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(models.size()));
    }
    for (const bool differs : differs_) trade_.class_frames += differs;
    return std::move(trade_);
  }

 private:
  SceneFrames frames_of(const Model& model, std::span<const std::size_t> numbers) const {
    std::map<std::string, double> parameters = options_.parameters;
    if (model.facets) parameters["facets"] = *model.facets;
    return load_scene_frames(file_, parameters, numbers, model.cover_level);
  }

  // A scene may refuse a count.
  bool is_taken(const Model& model) const {
    try {
      frames_of(model, std::vector<std::size_t>{0});
      return true;
    } catch (const InputError&) {
      return false;
    }
  }

  // Fewest hexahedra first, covers after the facets.
  std::vector<Model> models() const {
    std::vector<Model> models;
    if (stepped_.has_facets) {
      std::set<int> counts(options_.facets.begin(), options_.facets.end());
      counts.insert(static_cast<int>(stepped_.parameters.at("facets")));
      for (const int count : counts) {
        const Model model = {std::to_string(count) + " facets", count, {}};
        if (is_taken(model)) models.push_back(model);
      }
    } else {
      models.push_back({"as written", {}, {}});
    }
    for (int level = 0; level < stepped_.cover_levels; ++level)
      models.push_back({"cover, level " + std::to_string(level), {}, level});
    return models;
  }

  std::vector<ClearanceBracket> clearance(const SceneFrames& frames) const {
    std::vector<ClearanceBracket> brackets(frames.set.frames());
    if (frames.tubes.empty()) {
      const std::vector<double> exact = exact_clearance(frames.set, oracle_, measure_.threads);
      for (std::size_t f = 0; f < exact.size(); ++f) brackets[f] = {exact[f], exact[f]};
      return brackets;
    }
    parallel_chunks(brackets.size(), 1, measure_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f)
        brackets[f] = true_clearance(frames.set, f, frames.tubes, oracle_);
    });
    return brackets;
  }

  // The frame of the first true contact, or of the least clearance. Only some frames may have been stepped,
  // with facets for what is round: those between the two around what they show are looked at too.
  std::size_t first_contact_frame(std::span<const double> exact) const {
    const auto first = std::find_if(exact.begin(), exact.end(), [](double d) { return d <= 0.0; });
    const auto found = first != exact.end() ? first : std::min_element(exact.begin(), exact.end());
    const auto at = static_cast<std::size_t>(found - exact.begin());
    const std::vector<std::size_t>& numbers = stepped_.numbers;
    std::vector<std::size_t> between;
    for (std::size_t f = numbers[at > 0 ? at - 1 : 0]; f <= numbers[std::min(at + 1, numbers.size() - 1)];
         ++f)
      between.push_back(f);
    const std::vector<ClearanceBracket> truth = clearance(frames_of({}, between));
    const auto contact = std::find_if(truth.begin(), truth.end(), [](const auto& d) { return d.contact(); });
    const auto least = std::min_element(truth.begin(), truth.end(),
                                        [](const auto& a, const auto& b) { return a.high < b.high; });
    return between[static_cast<std::size_t>((contact != truth.end() ? contact : least) - truth.begin())];
  }

  void make_reference() {
    const SceneFrames written = frames_of({}, numbers_);
    reference_.round = trade_.round;
    reference_.clearance = clearance(written);
    reference_.written = exact_clearance(written.set, oracle_, measure_.threads);
    for (const Tube& tube : written.tubes)
      reference_.written_offset = std::max(reference_.written_offset, tube.offset);
    for (const ClearanceBracket& each : reference_.clearance)
      if (!each.contact()) trade_.reference_width = std::max(trade_.reference_width, each.high - each.low);
    differs_.assign(numbers_.size(), false);
  }

  void add_model(const Model& model) {
    const SceneFrames frames = frames_of(model, numbers_);
    const std::vector<double> exact = exact_clearance(frames.set, oracle_, measure_.threads);
    if (classes_.empty())
      for (const double d : exact) classes_.push_back(d <= 0.0);
    for (std::size_t f = 0; f < exact.size(); ++f)
      if ((exact[f] <= 0.0) != classes_[f]) differs_[f] = true;
    add_rows(model, frames, exact, {});
    if (model.cover_level) return;  // few pairs already
    std::set<std::size_t> looked_at(stepped_.numbers.begin(), stepped_.numbers.end());
    looked_at.insert(numbers_.begin(), numbers_.end());
    const SceneFrames motion = frames_of(model, std::vector<std::size_t>(looked_at.begin(), looked_at.end()));
    trade_.selection_frames = looked_at.size();
    const auto needed = pairs_that_decide(motion.set, stepped_.gap, oracle_, measure_.threads);
    if (needed.size() == frames.set.pairs.size()) return;
    SceneFrames selected = frames;
    selected.set.pairs.clear();
    selected.set.ids.clear();
    for (const std::size_t p : needed) selected.set.pairs.push_back(frames.set.pairs[p]);
    add_rows(model, selected, exact_clearance(selected.set, oracle_, measure_.threads),
             frames.set.pairs.size());
  }

  // `all_pairs` where only some of them are asked.
  void add_rows(const Model& model, const SceneFrames& frames, std::span<const double> exact,
                std::optional<std::size_t> all_pairs) {
    std::optional<double> offset;
    for (const Tube& tube : frames.tubes) offset = std::max(offset.value_or(0.0), tube.offset);
    for (const BackendAnswers& answers : answer_(frames.set, measure_)) {
      for (const QueryKind query : kQueryKinds) {
        const auto& timing = answers.frame_by_query[index_of(query)];
        if (!timing) continue;
        const QueryAnswers& given = answers.queries[index_of(query)];
        TradeRow& row = trade_.rows.emplace_back();
        row.backend = answers.name;
        row.model = model.name;
        row.hexahedra = frames.set.solids.size();
        row.selected = all_pairs.has_value();
        row.pairs = frames.set.pairs.size();
        row.all_pairs = all_pairs.value_or(row.pairs);
        row.query = query;
        row.frame_ns = quiet_median(*timing);
        row.geometry_error = geometry_error(reference_, exact, offset, query);
        row.backend_error = backend_error(given, query, row.pairs, exact);
        row.wrong_frames = wrong_frames(given, row.pairs, exact);
      }
    }
  }

  const std::string& file_;
  const SceneFrames& stepped_;
  const TradeOptions& options_;
  const Oracle& oracle_;
  const AnswerSet& answer_;
  MeasureOptions measure_;
  SceneTrade trade_;
  TradeReference reference_;
  std::vector<std::size_t> numbers_;
  std::vector<bool> classes_, differs_;
};

}  // namespace

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

SceneTrade run_trade(const std::string& file, const SceneFrames& stepped, std::span<const double> exact,
                     const TradeOptions& options, const Oracle& oracle, const AnswerSet& answer,
                     const Progress& progress) {
  return TradeRun(file, stepped, options, oracle, answer).run(exact, progress);
}

}  // namespace touchstone::comparison
