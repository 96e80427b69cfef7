#pragma once

#include <nlohmann/json.hpp>

#include "examples/compare_backends/report.hpp"

// The parts of results.json.

namespace touchstone::comparison {

using Json = nlohmann::ordered_json;

Json number(double value);  ///< NaN: null; infinite: "inf" or "-inf"
Json optional_number(const std::optional<double>& value);
Json json(const std::optional<Timing>& timing);
Json json(const Wrongness& wrongness);
Json json(const std::optional<Consistency>& consistency);
Json json(const SetResult& set);
Json json(const SceneResult& scene);
Json json(const BroadphaseResult& result);
Json json(const ThreadResult& run);
Json json(const GalleryCase& shown);
Json json(const Candidates& candidates);
Json json(const Verdict& verdict);
Json json(const Ranking& ranking);

}  // namespace touchstone::comparison
