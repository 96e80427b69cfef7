#pragma once

#include "touchstone/examples/compare_backends/run/report.hpp"
#include "touchstone/examples/program/files/json.hpp"

// The parts of results.json.

namespace touchstone::comparison {

Json optional_number(const std::optional<double>& value);
using program::json;
Json json(const std::optional<Timing>& timing);
Json json(const Wrongness& wrongness);
Json json(const std::optional<Consistency>& consistency);
Json json(const SetResult& set);
Json json(const PathSetResult& set);
Json json(const SceneResult& scene);
Json json(const SelectionRow& row);
Json json(const BroadphaseResult& result);
Json json(const DriftRun& run);
Json json(const ThreadResult& run);
Json json(const GalleryCase& shown);
/// The counts that verdicts are decided from, with the texts of their sentences.
Json json(const std::vector<ChoiceSet>& sets);
Json json(const Verdict& verdict);
Json json(const Ranking& ranking);

}  // namespace touchstone::comparison
