#pragma once

#include <string>

#include "touchstone/examples/compare_backends/judge/verdict.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// @param who, what name the reader and the file in an error: "diff", "the old file".
/// @throws InputError for what is no results.json of compare_backends.
Json parse_results(const std::string& text, const std::string& who, const std::string& what);

/// Returns the counts that verdicts are decided from.
/// @throws InputError where a figure is missing or of another format.
std::vector<ChoiceSet> choice_sets_of(const Json& results, const std::string& who);

/// "NEW is partial: the run ended early, without far, threads\n"; empty: it is complete.
/// @throws nlohmann::json::exception where not_measured is missing.
std::string partial_note(const Json& results, const std::string& what);

}  // namespace touchstone::comparison
