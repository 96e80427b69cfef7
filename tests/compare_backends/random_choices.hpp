#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/choice.hpp"
#include "touchstone/examples/measures/common/random.hpp"

namespace touchstone::comparison {

/// Two sets and nine backends with costs, coverages and times of all sizes; ties, a missing time, unsupported
/// and missing answers, a backend that one of the sets does not have.
std::vector<ChoiceSet> made_up_choice_sets(Random& random);

/// Of all that can be chosen; limits on the grids and off them. In some nothing is left.
Choice random_choice(Random& random, const std::vector<ChoiceSet>& sets);

/// As the page's script takes it; infinite limits are null.
nlohmann::json as_json(const Choice& choice);
Choice choice_from(const nlohmann::json& json);
/// As the command line takes it.
std::string as_options(const nlohmann::json& json);

}  // namespace touchstone::comparison
