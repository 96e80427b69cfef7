#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/report.hpp"

namespace touchstone::comparison {

/// least_that_serves.md: what each scene needs, by allowed error, and what switching objects off saves.
/// Markdown; two runs' pages differ in times and date alone. Empty where no scene was judged.
std::string least_that_serves_page(const Report& report);

}  // namespace touchstone::comparison
