#pragma once

#include <span>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// The answers judged and summed up; truth empty: not judged.
SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth, const Oracle* oracle,
                 std::span<const BackendAnswers> answers, int threads, const Progress& progress = {});

/// The same of errors that are known: one list a backend; none where nothing was judged.
SetResult sum_up(const PairSet& set, std::span<const PairTruth> truth,
                 std::span<const BackendAnswers> answers, std::span<const std::vector<CaseErrors>> errors);

}  // namespace touchstone::comparison
