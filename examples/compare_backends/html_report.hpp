#pragma once

#include <string>

#include "touchstone/examples/compare_backends/report.hpp"
#include "touchstone/examples/program/report_files.hpp"

namespace touchstone::comparison {

/// One self-contained page: no request; readable without its script, which re-ranks the
/// verdict for another allowed error; light, dark and print.
std::string html_report(const Report& report);

/// Every figure of the page as a file of its own, figures/*.svg.
std::vector<ReportFile> figure_files(const Report& report);

}  // namespace touchstone::comparison
