#pragma once

#include <string>

#include "touchstone/examples/compare_backends/report.hpp"

namespace touchstone::comparison {

/// The tables for a terminal of 120 columns.
std::string terminal_report(const Report& report);

/// The verdict and its ranking.
std::string verdict_text(const Verdict& verdict);

}  // namespace touchstone::comparison
