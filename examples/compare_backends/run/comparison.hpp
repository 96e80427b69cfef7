#pragma once

#include <filesystem>
#include <functional>

#include "touchstone/contact_core/motion/sweep.hpp"
#include "touchstone/examples/compare_backends/run/report.hpp"
#include "touchstone/examples/compare_backends/run/workers/worker.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"

namespace touchstone::comparison {

class ShardAnswers;

/// Where answers can come from.
struct Backends {
  BackendRegistry registry;
  std::vector<SweepEntry> sweeps;  ///< each is asked where the backend that it names is
  std::vector<Worker> workers;
  std::vector<Gap> gaps;
};

/// Name and description of the backends named by options.backends, or of all.
/// @throws InputError naming the known ones when one is unknown.
std::vector<std::pair<std::string, std::string>> chosen_backends(const Options& options,
                                                                 const Backends& backends);

/// The chosen backends' answers to a set, in this process or in a worker.
std::vector<BackendAnswers> answer_set(const Options& options, const Backends& backends, const PairSet& set,
                                       const MeasureOptions& measure, const Progress& progress = {});

/// Called with the report after each set, scene and part; not_measured names the rest.
using OnPart = std::function<void(const Report&)>;

/// Measures everything the options ask for. `oracle` may be null: errors are then not measured.
/// @param shards what was measured of the pairs in parts; null: they are measured here. What is not cut
/// (scenes, broadphases, threads) is measured here.
/// @throws InputError for unknown names and unreadable files, before anything is measured.
Report run_comparison(const Options& options, const Backends& backends, const Oracle* oracle,
                      ProgressLine& progress, const OnPart& on_part = {},
                      const ShardAnswers* shards = nullptr);

/// Measures options.shard of every set of pairs, and writes its file into options.output. Says what engines
/// printed meanwhile.
/// @return the file's path. @throws as run_comparison(), and as ShardWriter.
std::filesystem::path run_shard(const Options& options, const Backends& backends, const Oracle* oracle,
                                ProgressLine& progress);

}  // namespace touchstone::comparison
