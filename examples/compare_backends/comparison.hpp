#pragma once

#include "examples/compare_backends/progress.hpp"
#include "examples/compare_backends/report.hpp"

namespace touchstone::comparison {

/// Measures everything the options ask for. `oracle` may be null: errors are then not measured.
/// @throws InputError for unknown names and unreadable files, Interrupted on a signal.
Report run_comparison(const Options& options, const BackendRegistry& registry, const Oracle* oracle,
                      std::vector<Gap> gaps, ProgressLine& progress);

/// The answers judged and summed up; truth empty: not judged.
SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth, const Oracle* oracle,
                 std::span<const BackendAnswers> answers, int threads, const Progress& progress = {});

/// The entries named by options.backends, or all.
std::vector<const BackendRegistry::NarrowphaseEntry*> chosen_backends(const Options& options,
                                                                      const BackendRegistry& registry);

}  // namespace touchstone::comparison
