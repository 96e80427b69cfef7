#include "touchstone/examples/compare_backends/run/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/drift_file.hpp"
#include "touchstone/examples/compare_backends/run/replay_command.hpp"
#include "touchstone/examples/compare_backends/run/sets/path_judge.hpp"
#include "touchstone/examples/compare_backends/run/sets/set_summary.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard_file.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"

namespace touchstone::comparison {
namespace {

MeasureOptions measure_options(const Options& options) {
  MeasureOptions measure;
  measure.seed = options.seed;
  measure.threads = options.threads;
  measure.repetitions = options.repetitions;
  return measure;
}

// Of a scene; 0: all.
std::size_t most_frames(const Options& options) { return options.quick ? 100 : 0; }

std::vector<std::string> scene_names(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files) names.push_back(std::filesystem::path(file).stem().string());
  return names;
}

class Session {
 public:
  Session(const Options& options, const Backends& backends, const Oracle* oracle, ProgressLine& progress,
          const OnPart& on_part, const ShardAnswers* shards = nullptr)
      : options_(options),
        backends_(backends),
        oracle_(oracle),
        progress_(progress),
        on_part_(on_part),
        shards_(shards) {
    share_ = [this](double done) { progress_.share(done); };
  }

  void run_families(Report& report) {
    for (const std::string& name : chosen_families()) {
      report.sets.push_back(run_set(make_pair_family(name, options_.seed, options_.pair_count()), nullptr));
      finish_part(report, name);
    }
  }

  void run_corpus(Report& report) {
    if (!report.corpus) return;
    for (const CorpusSet& set : report.corpus->sets) {
      const PairSet pairs = corpus_pairs(*report.corpus, set);
      SetAnswers found;
      report.sets.push_back(run_set(
          pairs, nullptr, [&](const auto& truth) { check_truth(*report.corpus, set, truth); },
          set.is_paths() ? &found : nullptr));
      if (set.is_paths() && oracle_ != nullptr)
        report.path_sets.push_back(run_path_set(*report.corpus, set, pairs, found, backends_here(report)));
      finish_part(report, set.name);
    }
  }

  /// The parts to be measured, in this order.
  std::vector<std::string> parts(const std::optional<Corpus>& corpus, bool has_pairs) const {
    std::vector<std::string> names = chosen_families();
    if (corpus)
      for (const CorpusSet& set : corpus->sets) names.push_back(set.name);
    if (has_pairs) names.push_back("pairs");
    for (const std::string& file : options_.scenes) names.push_back("scene " + file);
    if (!options_.no_broadphase) names.insert(names.end(), {"broadphases", "selection"});
    if (!chosen_families().empty()) names.push_back("threads");
    return names;
  }

  /// Those that a choice can name.
  std::vector<std::string> set_names(const std::optional<Corpus>& corpus) const {
    std::vector<std::string> names = chosen_families();
    if (corpus)
      for (const CorpusSet& set : corpus->sets) names.push_back(set.name);
    if (!options_.pairs_file.empty()) names.push_back("pairs");
    for (std::string& name : scene_names(options_.scenes)) names.push_back(std::move(name));
    return names;
  }

  void run_pair_file(Report& report, PairFileCases cases) {
    PairFileResult& result = report.pair_file.emplace();
    result.cases = std::move(cases);
    if (!result.cases.set.pairs.empty()) report.sets.push_back(run_set(result.cases.set, &result));
    finish_part(report, "pairs");
  }

  /// The shard of every set.
  void run_parts(const Report& report, const std::optional<PairFileCases>& cases, ShardWriter& out) {
    const Shard shard = *options_.shard;
    for (const std::string& name : chosen_families()) {
      const std::size_t count = options_.pair_count();
      run_part(part_of_family(name, options_.seed, count, shard), count, nullptr, false, out);
    }
    if (report.corpus) {
      for (const CorpusSet& set : report.corpus->sets) {
        const PairSet whole = corpus_pairs(*report.corpus, set);
        run_part(part_of(whole, shard), whole.pairs.size(), nullptr, false, out);
      }
    }
    if (cases)
      run_part(part_of(cases->set, shard), cases->set.pairs.size(),
               cases->captured ? &*cases->captured : nullptr, true, out);
  }

  /// The distance query of the first family's pairs on one thread and more.
  void run_thread_counts(Report& report) {
    const std::vector<std::string> families = chosen_families();
    if (families.empty()) return;
    progress_.step(families.front() + ": threads");
    const auto here = backends_here(report);
    ThreadOptions threads;
    threads.threads = thread_counts();
    const std::size_t pairs = std::min<std::size_t>(options_.pair_count(), 1024);
    for (const auto& [name, description] : report.backends) {
      if (!is_here(name))
        report.thread_gaps.push_back({name, "runs in a process of its own, which is timed on one thread"});
    }
    report.thread_runs = run_threads(here, make_pair_family(families.front(), options_.seed, pairs), threads);
    for (ThreadResult& run : report.thread_runs) {
      for (const BackendResult& backend : report.sets.front().backends) {
        if (backend.name == run.backend) run.wrong = backend.judgement.wrongness[index_of(run.query)].total();
      }
    }
    finish_part(report, "threads");
  }

  /// Results over all sets and scenes together.
  void conclude(Report& report) const {
    report.engine_messages = engine_log_lines() + (shards_ == nullptr ? 0 : shards_->engine_messages());
    report.gallery = worst_of(gallery_);
    for (GalleryCase& shown : report.gallery) shown.replay = replay_command(report, shown.set, shown.id);
    report.rankings.clear();
    report.choices.clear();
    report.verdicts.clear();
    if (!report.has_truth) return;
    std::vector<SetResult> judged = report.sets;
    for (const SceneResult& scene : report.scenes) judged.push_back(scene.set);
    report.choices = choice_sets(judged);
    for (const QueryKind kind : kQueryKinds) {
      if (!report.sets.empty()) report.rankings.push_back(rank(report.sets, kind));
      if (!options_.max_error || report.choices.empty()) continue;
      Choice choice = options_.choice;
      choice.query = kind;
      if (kind != QueryKind::manifold) choice.min_coverage = 0;
      const bool asked = kind == options_.choice.query;
      report.verdicts.insert(asked ? report.verdicts.begin() : report.verdicts.end(),
                             decide(report.choices, choice));
    }
  }

  void run_broadphase_sizes(Report& report) {
    BroadphaseOptions broadphase;
    broadphase.seed = options_.seed;
    broadphase.threads = options_.threads;
    if (options_.quick) broadphase.swarms = {{1000, 1}, {250, 4}};
    progress_.step("broadphases");
    report.broadphases = run_broadphases(backends_.registry, broadphase, oracle_, share_);
    finish_part(report, "broadphases");
  }

  void run_selection_gain(Report& report) {
    progress_.step("selection");
    SelectionOptions selection;
    selection.seed = options_.seed;
    if (options_.quick) selection.repetitions = 1;
    report.selection = run_selection(selection);
    finish_part(report, "selection");
  }

  void run_scenes(Report& report) {
    SceneOptions scene;
    scene.measure = measure_options(options_);
    scene.max_error = options_.max_error;
    if (options_.quick) scene.trade_frames = 10;
    scene.most_frames = most_frames(options_);
    for (const std::string& file : options_.scenes) {
      progress_.step("scene " + file);
      scene.parameters = parameters_for(file, options_.scene_settings);
      const AnswerSet answer = [&](const PairSet& set, const MeasureOptions& measure) {
        return answer_set(options_, backends_, set, measure, share_);
      };
      report.scenes.push_back(run_scene(file, scene, oracle_, answer, share_));
      auto& worst = report.scenes.back().worst_cases;
      std::move(worst.begin(), worst.end(), std::back_inserter(gallery_));
      worst.clear();
      finish_part(report, "scene " + file);
    }
  }

  std::vector<std::string> chosen_families() const {
    if (!options_.families.empty() || options_.no_families) return options_.families;
    std::vector<std::string> names;
    for (const PairFamily& family : pair_families()) names.emplace_back(family.name);
    return names;
  }

 private:
  /// Not timed.
  void finish_part(Report& report, const std::string& name) const {
    std::erase(report.not_measured, name);
    progress_.part_done();
    if (!on_part_ || report.not_measured.empty()) return;
    conclude(report);
    on_part_(report);
  }

  bool is_here(const std::string& name) const {
    return std::none_of(backends_.workers.begin(), backends_.workers.end(),
                        [&](const Worker& worker) { return worker.offers(name); });
  }

  std::vector<const BackendRegistry::NarrowphaseEntry*> backends_here(const Report& report) const {
    std::vector<const BackendRegistry::NarrowphaseEntry*> here;
    for (const auto& [name, description] : report.backends)
      if (is_here(name)) here.push_back(&backends_.registry.narrowphase(name));
    return here;
  }

  /// The sweeps of the engines of these backends.
  std::vector<const SweepEntry*> sweeps_of(
      std::span<const BackendRegistry::NarrowphaseEntry* const> here) const {
    std::vector<const SweepEntry*> sweeps;
    for (const SweepEntry& sweep : backends_.sweeps)
      if (std::any_of(here.begin(), here.end(),
                      [&](const auto* entry) { return entry->name == sweep.backend; }))
        sweeps.push_back(&sweep);
    return sweeps;
  }

  /// Times of impact. @param found what was answered about the set's pairs.
  PathSetResult run_path_set(const Corpus& corpus, const CorpusSet& set, const PairSet& pairs,
                             const SetAnswers& found,
                             std::span<const BackendRegistry::NarrowphaseEntry* const> here) {
    progress_.step(set.name + ": times of impact");
    const PathJudge judge(corpus, set, pairs, found.truth, *oracle_, options_.threads);
    PathSetResult result = judge.begin();
    for (const BackendAnswers& each : found.answers) result.backends.push_back(judge.result_of(each, here));
    for (const SweepEntry* sweep : sweeps_of(here)) result.backends.push_back(judge.result_of(*sweep));
    return result;
  }

  using CheckTruth = std::function<void(std::span<const PairTruth>)>;

  /// @param set its exact separations are filled in. @param captured answers of an engine, or null.
  SetAnswers measure(PairSet& set, const MeasureOptions& measure, const BackendAnswers* captured,
                     const CheckTruth& check) {
    SetAnswers found;
    if (oracle_ != nullptr) {
      progress_.step(set.name + ": exact answers");
      found.truth = compute_truth(set, *oracle_, options_.threads, share_);
      if (check) check(found.truth);
      for (const PairTruth& each : found.truth) set.exact_separations.push_back(each.separation);
    }
    progress_.step(set.name + ": backends");
    found.answers = answer_set(options_, backends_, set, measure, share_);
    for (BackendAnswers& each : found.answers)
      if (oracle_ != nullptr) take_worse_answers(set, found.truth, *oracle_, each, options_.threads);
    if (captured != nullptr) found.answers.push_back(*captured);
    progress_.step(set.name + ": errors");
    return found;
  }

  /// @param check what the set's truth must hold. @param answers gets what was found, where it is given.
  SetResult run_set(PairSet set, PairFileResult* keep, const CheckTruth& check = {},
                    SetAnswers* answers = nullptr) {
    // Answers come from shards of this run, or are measured now.
    SetAnswers found;
    SetResult result;
    if (shards_ != nullptr) {
      progress_.step(set.name + ": from its shards");
      found = shards_->of(set, keep != nullptr);
      if (check && oracle_ != nullptr) check(found.truth);
      result = sum_up(set, found.truth, found.answers, found.errors);
    } else {
      MeasureOptions measured = measure_options(options_);
      measured.check_consistency = true;
      const bool has_captured = keep != nullptr && keep->cases.captured;
      found = measure(set, measured, has_captured ? &*keep->cases.captured : nullptr, check);
      result = sum_up(set, found.truth, oracle_, found.answers, options_.threads, share_);
    }
    // The gallery, the pair file's part and the shard's writer take what they need.
    if (oracle_ != nullptr) collect_cases(set, found.truth, found.answers, result, gallery_);
    if (keep != nullptr) {
      keep->truth = std::move(found.truth);
      keep->answers = std::move(found.answers);
    }
    if (answers != nullptr) *answers = std::move(found);
    return result;
  }

  /// @param set the shard's part. @param cases of the whole set. @param captured answers to the whole set.
  /// @param keeps_points what a pair file's answers show.
  void run_part(PairSet set, std::size_t cases, const BackendAnswers* captured, bool keeps_points,
                ShardWriter& out) {
    const Shard shard = *options_.shard;
    MeasureOptions measured = measure_options(options_);
    measured.check_consistency = true;
    measured.first_case = shard.k - 1;
    measured.case_stride = shard.n;
    std::optional<BackendAnswers> captured_part;
    if (captured != nullptr) captured_part = part_of(*captured, shard);
    SetAnswers found = measure(set, measured, captured_part ? &*captured_part : nullptr, {});
    if (oracle_ != nullptr)
      found.errors = all_case_errors(set, found.truth, *oracle_, found.answers, options_.threads, share_);
    for (BackendAnswers& backend : found.answers) {
      backend.perturbed = {};
      if (keeps_points) continue;
      for (QueryAnswers& query : backend.queries) query.points.clear();
    }
    out.add(set.name, cases, found);
    progress_.part_done();
  }

  const Options& options_;
  const Backends& backends_;
  const Oracle* oracle_;
  ProgressLine& progress_;
  const OnPart& on_part_;
  const ShardAnswers* shards_;
  Progress share_;
  std::vector<GalleryCase> gallery_;
};

std::vector<std::string> known_names(const Backends& backends) {
  std::vector<std::string> names;
  for (const auto& entry : backends.registry.narrowphases()) names.push_back(entry.name);
  for (const Worker& worker : backends.workers) {
    for (const auto& backend : worker.backends) names.push_back(backend.first);
  }
  return names;
}

std::string describe(const Backends& backends, const std::string& name) {
  for (const Worker& worker : backends.workers) {
    for (const auto& backend : worker.backends) {
      if (backend.first == name) return backend.second;
    }
  }
  return backends.registry.narrowphase(name).description;
}

// Ids, figures and settings go by these names.
void check_once(const std::string& option, std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  const auto again = std::adjacent_find(names.begin(), names.end());
  if (again != names.end()) throw InputError(option + ": '" + *again + "' is given twice");
}

// Families, and what is no set of cases (threads, broadphases), count as one family's cases.
std::vector<PlannedPart> planned(const std::vector<std::string>& parts,
                                 const std::map<std::string, double>& cases_of, double family_cases) {
  std::vector<PlannedPart> plan;
  for (const std::string& part : parts) {
    const auto cases = cases_of.find(part);
    if (cases != cases_of.end())
      plan.push_back({part.starts_with("scene ") ? "scene" : "family", cases->second});
    else
      plan.push_back({part == "threads" || part == "broadphases" || part == "selection" ? part : "family",
                      family_cases});
  }
  return plan;
}

void check_known(const Backends& backends, const std::string& name) {
  const std::vector<std::string> known = known_names(backends);
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw InputError("unknown backend '" + name + "', this build knows: " + joined(known));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> chosen_backends(const Options& options,
                                                                 const Backends& backends) {
  check_once("--backend", options.backends);
  std::vector<std::pair<std::string, std::string>> chosen;
  for (const std::string& name : options.backends.empty() ? known_names(backends) : options.backends) {
    check_known(backends, name);
    chosen.emplace_back(name, describe(backends, name));
  }
  return chosen;
}

std::vector<BackendAnswers> answer_set(const Options& options, const Backends& backends, const PairSet& set,
                                       const MeasureOptions& measure, const Progress& progress) {
  std::vector<const BackendRegistry::NarrowphaseEntry*> here;
  std::vector<std::vector<std::string>> there(backends.workers.size());
  for (const auto& [name, description] : chosen_backends(options, backends)) {
    const auto worker = std::find_if(backends.workers.begin(), backends.workers.end(),
                                     [&, &wanted = name](const Worker& each) { return each.offers(wanted); });
    if (worker == backends.workers.end())
      here.push_back(&backends.registry.narrowphase(name));
    else
      there[static_cast<std::size_t>(worker - backends.workers.begin())].push_back(name);
  }
  std::vector<BackendAnswers> answers = run_backends(here, set, measure, progress);
  for (std::size_t w = 0; w < backends.workers.size(); ++w) {
    if (there[w].empty()) continue;
    auto more = run_in_worker(backends.workers[w], there[w], set, measure, progress);
    std::move(more.begin(), more.end(), std::back_inserter(answers));
  }
  return answers;
}

namespace {

/// A run before anything is measured.
struct Inputs {
  Report report;
  std::optional<PairFileCases> cases;
  std::map<std::string, double> cases_of;  ///< what a part that is no family counts
};

/// Bad input ends the run here.
Inputs read_inputs(const Options& options, const Backends& backends, const Oracle* oracle,
                   const Session& session) {
  Inputs in;
  Report& report = in.report;
  report.machine = describe_machine();
  report.options = options;
  report.gaps = backends.gaps;
  report.has_truth = oracle != nullptr;
  report.backends = chosen_backends(options, backends);
  // Names and files are checked before anything is measured.
  check_once("--families", options.families);
  check_once("--scene", scene_names(options.scenes));
  for (const std::string& name : session.chosen_families()) make_pair_family(name, options.seed, 0);
  for (const std::string& file : options.scenes)
    in.cases_of["scene " + file] =
        check_scene_length(file, parameters_for(file, options.scene_settings), most_frames(options));
  check_settings(options.scenes, options.scene_settings);
  if (!options.corpus.empty()) report.corpus = load_corpus(options.corpus);
  check_sets(options.choice, session.set_names(report.corpus));
  // Files of pairs and of dynamics.
  if (!options.pairs_file.empty()) in.cases = load_pair_file(options.pairs_file);
  if (options.is_capture && !in.cases->captured)
    throw InputError(options.pairs_file +
                     ": no case has an engine's answer; cases without one are compared with --pairs");
  if (!options.dynamics_file.empty()) report.drift = load_drift(options.dynamics_file);
  // How many cases each set has, for the progress.
  if (report.corpus)
    for (const CorpusSet& set : report.corpus->sets) in.cases_of[set.name] = static_cast<double>(set.cases);
  if (in.cases) in.cases_of["pairs"] = static_cast<double>(in.cases->set.pairs.size());
  return in;
}

}  // namespace

Report run_comparison(const Options& options, const Backends& backends, const Oracle* oracle,
                      ProgressLine& progress, const OnPart& on_part, const ShardAnswers* shards) {
  Session session(options, backends, oracle, progress, on_part, shards);
  Inputs in = read_inputs(options, backends, oracle, session);
  Report& report = in.report;
  if (shards != nullptr) {
    shards->check(report);
    report.elsewhere = shards->elsewhere(report.machine);
  }
  // The parts, in order; each takes its name off the list.
  report.not_measured = session.parts(report.corpus, in.cases.has_value());
  progress.plan(planned(report.not_measured, in.cases_of, static_cast<double>(options.pair_count())));
  session.run_families(report);
  session.run_corpus(report);
  if (in.cases) session.run_pair_file(report, std::move(*in.cases));
  session.run_scenes(report);
  if (!options.no_broadphase) session.run_broadphase_sizes(report);
  if (!options.no_broadphase) session.run_selection_gain(report);
  session.run_thread_counts(report);
  session.conclude(report);
  progress.finish();
  return std::move(report);
}

std::filesystem::path run_shard(const Options& options, const Backends& backends, const Oracle* oracle,
                                ProgressLine& progress) {
  const OnPart no_report;
  Session session(options, backends, oracle, progress, no_report);
  Inputs in = read_inputs(options, backends, oracle, session);
  ShardWriter out(options.output, *options.shard, options.shared_arguments);
  const EngineLog log;
  std::vector<std::string> sets = session.set_names(in.report.corpus);
  sets.resize(sets.size() - options.scenes.size());  // they come last, and are measured by the merge
  progress.plan(planned(sets, in.cases_of, static_cast<double>(options.pair_count())));
  session.run_parts(in.report, in.cases, out);
  in.report.engine_messages = engine_log_lines();
  progress.finish();
  say(log.text());  // the file has their number alone
  return out.finish(in.report);
}

}  // namespace touchstone::comparison
