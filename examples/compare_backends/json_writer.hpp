#pragma once

#include <string>

#include "touchstone/examples/compare_backends/report.hpp"

namespace touchstone::comparison {

inline constexpr int kResultsSchema = 1;

/// The whole report as JSON. A figure that was not measured is null, an infinite one the string "inf".
std::string results_json(const Report& report);

/// The candidates alone, as in results_json, fit to stand in a page: what the slider decides from.
std::string candidates_json(const Report& report);

/// One row per pair set, backend and query.
std::string results_csv(const Report& report);

}  // namespace touchstone::comparison
