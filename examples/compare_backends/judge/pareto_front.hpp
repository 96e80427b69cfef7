#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/judge/set_result.hpp"

namespace touchstone::comparison {

/// The backends without a wrong or missing answer that no other such beats in both worst error and median
/// time, from the most exact to the fastest.
std::vector<std::string> pareto_front(const SetResult& set, QueryKind query);

}  // namespace touchstone::comparison
