#pragma once

#include <string>

#include "examples/compare_backends/report.hpp"
#include "examples/program/report_files.hpp"

namespace touchstone::comparison {

/// One self-contained page: no request, no script; light, dark and print.
std::string html_report(const Report& report);

/// figures/<set>_<query>.svg for every set that was judged.
std::vector<ReportFile> figure_files(const Report& report);

}  // namespace touchstone::comparison
