#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/dynamics_drift.hpp"
#include "touchstone/examples/compare_backends/judge/gallery.hpp"
#include "touchstone/examples/compare_backends/judge/path_result.hpp"
#include "touchstone/examples/compare_backends/judge/ranking.hpp"
#include "touchstone/examples/compare_backends/judge/set_result.hpp"
#include "touchstone/examples/compare_backends/judge/verdict.hpp"
#include "touchstone/examples/compare_backends/run/scenes/scene_run.hpp"
#include "touchstone/examples/compare_backends/run/selection_gain.hpp"
#include "touchstone/examples/compare_backends/run/sets/corpus.hpp"
#include "touchstone/examples/compare_backends/run/sets/options.hpp"
#include "touchstone/examples/compare_backends/run/sets/pair_file_run.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard.hpp"
#include "touchstone/examples/measures/runs/broadphase_run.hpp"
#include "touchstone/examples/measures/runs/thread_run.hpp"
#include "touchstone/examples/program/terminal/machine.hpp"

namespace touchstone::comparison {

/// A backend or part that is not in this build, or that died, and why.
struct Gap {
  std::string what;
  std::string why;
};

/// Where a shard of a merge was measured.
struct ShardMachine {
  Shard shard;
  std::string cpu, instruction_set, compiler;
};

/// Everything one run found out; every output file is written from this alone.
struct Report {
  Machine machine;
  std::vector<ShardMachine> elsewhere;  ///< of a merge: the shards of other machines than `machine`
  Options options;
  std::vector<std::pair<std::string, std::string>> backends;  ///< name and description with version
  std::vector<Gap> gaps;
  /// Sets, scenes and parts that a run which ended early did not come to; empty: a complete one.
  std::vector<std::string> not_measured;
  /// Lines that engines wrote by themselves, to engines.log; in shards to standard error.
  std::size_t engine_messages = 0;
  bool has_truth = false;
  std::optional<Corpus> corpus;             ///< of --corpus
  std::vector<SetResult> sets;              ///< families, the corpus's, then the pair file
  std::vector<PathSetResult> path_sets;     ///< of those of the corpus's that are paths; empty without truth
  std::optional<PairFileResult> pair_file;  ///< the answers behind the last of `sets`
  std::vector<BroadphaseResult> broadphases;
  std::vector<SceneResult> scenes;
  std::vector<SelectionRow> selection;    ///< with the broadphases
  Drift drift;                            ///< of --dynamics
  std::vector<ThreadResult> thread_runs;  ///< of the backends in this process
  std::vector<Gap> thread_gaps;           ///< the other backends, and why
  std::vector<GalleryCase> gallery;       ///< the worst first
  std::vector<Ranking> rankings;          ///< one a query, over `sets`; empty without truth
  std::vector<ChoiceSet> choices;         ///< of `sets` and the scenes' cases; empty without truth
  std::vector<Verdict> verdicts;          ///< with --max-error: one a query, that of --query first
};

}  // namespace touchstone::comparison
