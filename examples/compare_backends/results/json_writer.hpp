#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

inline constexpr int kResultsSchema = 2;

/// The whole report as JSON. A figure that was not measured is null, an infinite one the string "inf".
std::string results_json(const Report& report);

/// `choices` alone, as in results_json, to be embedded in the page, which decides from it.
std::string choices_json(const Report& report);

/// One row per pair set, backend and query.
std::string results_csv(const Report& report);

}  // namespace touchstone::comparison
